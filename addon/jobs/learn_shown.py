"""What would be learned, looked at before it is taken: one shape key that shows key after key."""

from typing import NamedTuple

import bpy

from .. import session
from ..bridge import pins, shape_keys

PREVIEW = "Learned Preview"


class Shown(NamedTuple):
    """The object by name, and the shapes of its keys as they would be, {name: (n, 3)}."""

    object: str
    shapes: dict


def start(obj, shapes, settings):
    """Looks at ``shapes``, {name: (n, 3)}, of an object, by the rows of the scene's list."""
    stop()
    shape_keys.write(obj, PREVIEW, next(iter(shapes.values())))
    pins.show(obj, obj.data.shape_keys.key_blocks.find(PREVIEW))
    session.learned = Shown(obj.name, shapes)
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
    if obj is not None:
        take_away(obj)


def take_away(obj):
    """The same of an object that undo, redo or a file brought a preview back to."""
    if obj.data.shape_keys and PREVIEW in obj.data.shape_keys.key_blocks:
        shape_keys.remove(obj, PREVIEW)
    pins.give_back(obj)


def shows(obj):
    """Whether the preview is looked at on this object."""
    return session.learned is not None and session.learned.object == obj.name
