"""What would be learned, looked at before it is taken: one shape key that shows key after key."""

from typing import NamedTuple

import bpy

from .. import session
from ..bridge import shape_keys

PREVIEW = "Learned Preview"


class Shown(NamedTuple):
    """The object by name, the shapes of its keys as they would be, {name: (n, 3)}, and what it showed before:
    the place of its active key and whether that was pinned.
    """

    object: str
    shapes: dict
    before: tuple


def start(obj, shapes, settings):
    """Looks at ``shapes``, {name: (n, 3)}, of an object, by the rows of the scene's list."""
    stop()
    before = obj.active_shape_key_index, obj.show_only_shape_key
    shape_keys.write(obj, PREVIEW, next(iter(shapes.values())))
    obj.active_shape_key_index = obj.data.shape_keys.key_blocks.find(PREVIEW)
    obj.show_only_shape_key = True
    session.learned = Shown(obj.name, shapes, before)
    settings.active_learned = 0


def show_row(scene):
    """Shows what the active row of the scene's list is about."""
    shown, settings = session.learned, scene.lissom_transfer
    obj = bpy.data.objects.get(shown.object) if shown else None
    place = settings.active_learned
    if obj is None or obj.data.shape_keys is None or not 0 <= place < len(settings.learned):
        return
    key = obj.data.shape_keys.key_blocks.get(PREVIEW)
    shape = shown.shapes.get(settings.learned[place].name)
    if key is not None and shape is not None and len(shape) == len(key.data):
        shape_keys.write_points(key, shape)


def stop():
    """Takes the preview away; the object shows what it did before."""
    shown, session.learned = session.learned, None
    obj = bpy.data.objects.get(shown.object) if shown else None
    if obj is None:
        return
    if obj.data.shape_keys and PREVIEW in obj.data.shape_keys.key_blocks:
        shape_keys.remove(obj, PREVIEW)
    obj.active_shape_key_index, obj.show_only_shape_key = shown.before
