"""Registers the add-on in this environment's bpy, under the name that Blender gives an extension."""

import importlib.util
import os
import pathlib
import sys
import types

import bpy
import pytest

HERE = pathlib.Path(__file__).parent
ADDON = HERE.parents[1] / "addon"
PACKAGE = "bl_ext.user_default.lissom"

sys.path.insert(0, str(HERE))  # for scene.py


def load():
    """Imports addon/ as Blender does."""
    for name in ("bl_ext", "bl_ext.user_default"):
        sys.modules.setdefault(name, types.ModuleType(name)).__path__ = []
    spec = importlib.util.spec_from_file_location(
        PACKAGE, ADDON / "__init__.py", submodule_search_locations=[str(ADDON)]
    )
    module = importlib.util.module_from_spec(spec)
    sys.modules[PACKAGE] = module
    spec.loader.exec_module(module)
    return module


_package = load()  # here already: test modules import from it


@pytest.fixture(scope="session", autouse=True)
def addon():
    """The registered package."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    _package.register()
    yield _package
    _package.unregister()


@pytest.fixture(autouse=True)
def empty_file(addon):
    """Every test starts from an empty file; the factory's preferences, which take six times as long, stay."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    bpy.context.window_manager.property_unset("lissom_page")


_status = pytest.StashKey[int]()


def pytest_sessionfinish(session, exitstatus):
    session.config.stash[_status] = int(exitstatus)


@pytest.hookimpl(trylast=True)
def pytest_unconfigure(config):
    """Leaves at once with the tests' own status, where Blender as a module would crash on its way out.

    4.2 does so in any process that has registered an operator or a handler, ours or another's.
    """
    if bpy.app.version < (4, 3) and _status in config.stash:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(config.stash[_status])
