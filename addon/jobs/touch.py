"""A press on the mesh itself: the handle under it is taken, or one is made, and the mesh is bound."""

from dataclasses import dataclass

from mathutils import Vector

from ..bridge import brush, checks, meshes, poses, standing
from ..bridge.generative import evaluated
from . import bound
from .pose import Bind, bind_asked


@dataclass
class Touch:
    """``handle``: its name, ``made`` where it is new; ``place``: where in the world it was taken."""

    handle: str
    empty: str  # its name
    place: Vector
    made: bool


def at(context, obj, spot, radius, pin=False):
    """The Touch of a spot of the view, (x, y) in pixels, on a mesh object; None beside it."""
    checks.require_writable(obj)
    name = brush.handle_at(context, obj, spot)
    if name is not None:
        place = obj.lissom_pose.handles[name].empty.matrix_world.translation.copy()
        return _taken(context, obj, name, place, made=False)
    found = brush.hit(context, obj, spot)
    return None if found is None else on(context, obj, found, radius, pin)


def on(context, obj, found, radius, pin=False):
    """The same of a bridge.brush.Hit: with ``pin`` a new handle is named so, else it is to be dragged."""
    name = brush.handle_of(obj, found.vertex)
    made = name is None
    if made:
        name = add(context, obj, found, radius, pin).name
    return _taken(context, obj, name, found.place, made)


def add(context, obj, found, radius, pin=False):
    """A new handle of a bridge.brush.Hit, or a pin; its row in the list."""
    return brush.add(context, obj, found, radius, _shapes(obj), pin)


def _shapes(obj):
    """The mesh at rest and as it is posed now, as Bind takes or took it: standing or not."""
    if not obj.lissom_pose.bound:
        return [standing.shown(obj)] * 2
    skin = bound.skin_of(obj)
    if skin is None:
        return meshes.rest_positions(obj.data), meshes.positions(poses.preview(obj).points)
    return skin.shown, meshes.positions(evaluated(obj).data.vertices)


def _taken(context, obj, name, place, made):
    settings = obj.lissom_pose
    if not settings.bound:
        settings.use_weights = True  # a brush has a soft rim
        bind = Bind(context, bind_asked(obj))
        bind.write(context, bind.work.wait())
    settings.active_handle = settings.handles.find(name)
    empty = settings.handles[name].empty
    for other in context.selected_objects:
        other.select_set(False)
    empty.select_set(True)
    return Touch(name, empty.name, place, made)
