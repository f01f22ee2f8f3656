"""Registers the add-on in this environment's bpy, under the name that Blender gives an extension."""

import importlib.util
import pathlib
import sys
import types

import bpy
import pytest

ADDON = pathlib.Path(__file__).parents[2] / "addon"
PACKAGE = "bl_ext.user_default.lissom"


def _load():
    for name in ("bl_ext", "bl_ext.user_default"):
        sys.modules.setdefault(name, types.ModuleType(name)).__path__ = []
    spec = importlib.util.spec_from_file_location(
        PACKAGE, ADDON / "__init__.py", submodule_search_locations=[str(ADDON)]
    )
    module = importlib.util.module_from_spec(spec)
    sys.modules[PACKAGE] = module
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="session", autouse=True)
def addon():
    module = _load()
    module.register()
    yield module
    module.unregister()


@pytest.fixture(autouse=True)
def empty_file(addon):
    """Every test starts from an empty file."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
