"""How random tests are drawn: always the same few, or by `--hypothesis-profile=search` many new ones."""

from hypothesis import HealthCheck, settings

LASTING = {"deadline": None, "suppress_health_check": list(HealthCheck)}
settings.register_profile("steady", max_examples=40, derandomize=True, database=None, **LASTING)
settings.register_profile("search", max_examples=2000, **LASTING)
settings.load_profile("steady")
