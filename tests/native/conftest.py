"""How random tests are drawn: always the same few, or by `--hypothesis-profile=search` many new ones.

`fuzz` is what `make fuzz` repeats; there half a minute for one case is a fault.
"""

from datetime import timedelta

from hypothesis import HealthCheck, settings

LASTING = {"deadline": None, "suppress_health_check": list(HealthCheck)}
settings.register_profile("steady", max_examples=40, derandomize=True, database=None, **LASTING)
settings.register_profile("search", max_examples=2000, **LASTING)
settings.register_profile(
    "fuzz",
    settings.get_profile("search"),
    max_examples=1500,
    deadline=timedelta(seconds=30),
    print_blob=True,
)
settings.load_profile("steady")
