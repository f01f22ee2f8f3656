"""Loads addon/core by itself, under a name of its own: it needs no Blender."""

import importlib.util
import pathlib
import sys

from hypothesis import HealthCheck, settings

settings.register_profile("lasting", deadline=None, suppress_health_check=list(HealthCheck), max_examples=40)
settings.load_profile("lasting")

_CORE = pathlib.Path(__file__).parents[2] / "addon" / "core"
_spec = importlib.util.spec_from_file_location(
    "lissom_addon_core", _CORE / "__init__.py", submodule_search_locations=[str(_CORE)]
)
sys.modules["lissom_addon_core"] = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(sys.modules["lissom_addon_core"])
