"""3D views: what each of them shows, and where it looks."""

import bpy
import numpy as np
from mathutils import Quaternion, Vector

from ..core.framing import framed, free_span
from ..core.refused import Refused


def region_of(area, kind="WINDOW"):
    """The region of that kind."""
    return next(region for region in area.regions if region.type == kind)


def of_address(address):
    """(window, area) of a 3D view by its address, or None where it is closed."""
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.as_pointer() == address and area.type == "VIEW_3D":
                return window, area
    return None


def under(window, x, y):
    """Whether the mouse is over a 3D view of a window."""
    return any(
        area.type == "VIEW_3D" and 0 <= x - area.x < area.width and 0 <= y - area.y < area.height
        for area in window.screen.areas
    )


def split(context, sides):
    """Splits the 3D view of the context, each of two ``sides`` alone in one; their addresses, the own first.

    The new view is the left one and shows the first side. Until Blender has drawn both, neither knows its
    place: ``frame`` them then.
    """
    if context.area is None or context.area.type != "VIEW_3D":
        raise Refused("A 3D view is split in two: press it in one")
    if context.space_data.local_view is not None:
        raise Refused("This view is in Local View: leave it first (View > Local View)")
    own, before = context.area, set(context.screen.areas)
    sidebar = region_of(own, "UI").width
    bpy.ops.screen.area_split(direction="VERTICAL", factor=max(0.5 - 0.5 * sidebar / own.width, 0.25))
    (new,) = set(context.screen.areas) - before
    new.spaces.active.show_region_ui = False
    for area, objects in zip((new, own), sides, strict=True):
        _show_alone(context, area, objects)
    return own.as_pointer(), new.as_pointer()


def together(context, addresses):
    """Back to one view of the two, which looks as it did before; what was closed meanwhile is left alone."""
    areas = {area.as_pointer(): area for area in context.screen.areas if area.type == "VIEW_3D"}
    own, new = map(areas.get, addresses)
    for area in filter(None, (own, new)):
        if area.spaces.active.local_view is not None:
            with context.temp_override(area=area, region=region_of(area)):
                bpy.ops.view3d.localview(frame_selected=True)
    if own and new:
        with context.temp_override(area=new, region=region_of(new)):
            bpy.ops.screen.area_close()


def _show_alone(context, area, objects):
    """Shows these objects and nothing else in a view; the selection stays as it was."""
    selected = {obj: obj.select_get() for obj in context.view_layer.objects}
    for obj in selected:
        obj.select_set(obj in objects)
    with context.temp_override(area=area, region=region_of(area)):
        bpy.ops.view3d.localview(frame_selected=True)
    for obj, was in selected.items():
        obj.select_set(was)


def frame(addresses):
    """Has each view that is in Local View show its meshes beside what covers it."""
    for window, area in filter(None, map(of_address, addresses)):
        space = area.spaces.active
        if space.local_view is not None:
            shown = (obj for obj in window.view_layer.objects if obj.type == "MESH")
            look_at(area, box([obj for obj in shown if obj.visible_get(viewport=space)]))


def box(objects):
    """(8 k, 3): the corners of the boxes around objects, in the world."""
    return np.array([obj.matrix_world @ Vector(corner) for obj in objects for corner in obj.bound_box])


def look_at(area, corners, towards=None):
    """Has a view show places (k, 3) of the world where nothing covers it.

    ``towards`` (3,) is the way it looks, by default as it does.
    """
    region, data = region_of(area), area.spaces.active.region_3d
    if towards is not None:
        data.view_rotation = Vector(-np.asarray(towards)).to_track_quat("Z", "Y")
    covering = [
        (bar.x - region.x, bar.x - region.x + bar.width)
        for bar in (region_of(area, "UI"), region_of(area, "TOOLS"))
        if bar.width > 1
    ]
    across = 2 / data.window_matrix[0][0] * (data.view_distance if data.is_perspective else 1)
    size = region.width, region.height
    data.view_location, factor = framed(
        corners,
        np.array(data.view_rotation.to_matrix()),
        size,
        free_span(region.width, covering),
        across / region.width,
    )
    data.view_distance *= factor


class Linked:
    """Two views that look at two things alike: as one is turned, moved or zoomed, so is the other."""

    def __init__(self, addresses, boxes):
        """``boxes`` are the corners (k, 3) of what each looks at."""
        self._addresses = addresses
        self._middles = [corners.mean(axis=0) for corners in boxes]
        self._sizes = [float(np.linalg.norm(np.ptp(corners, axis=0))) for corners in boxes]
        self._last = None

    def follow(self):
        """Has the view follow that was not touched since the last time; at first the second one."""
        found = list(map(of_address, self._addresses))
        if None in found:
            return
        views = [area.spaces.active.region_3d for _, area in found]
        now = [self._state(place, view) for place, view in enumerate(views)]
        leader = 0 if self._last is None or not _same(now[0], self._last[0]) else 1
        if self._last is None or not all(map(_same, now, self._last)):
            turn, way, offset, distance = now[leader]
            other = 1 - leader
            views[other].view_perspective = "PERSP" if way == "CAMERA" else way
            views[other].view_rotation = Quaternion(turn)
            views[other].view_location = self._middles[other] + np.array(offset) * self._sizes[other]
            views[other].view_distance = distance * self._sizes[other]
            now[other] = self._state(other, views[other])
        self._last = now

    def _state(self, place, view):
        """Where a view looks, as parts of the size of what it looks at."""
        size = self._sizes[place]
        offset = (np.array(view.view_location) - self._middles[place]) / size
        return tuple(view.view_rotation), view.view_perspective, tuple(offset), view.view_distance / size


def _same(one, other):
    return one[1] == other[1] and all(
        np.allclose(a, b, atol=1e-5) for a, b in zip(one[::2] + one[3:], other[::2] + other[3:], strict=True)
    )


def looks(addresses):
    """Where 3D views look, by address, for ``look_again``."""
    found = {address: of_address(address) for address in addresses}
    return {address: _look(one[1].spaces.active.region_3d) for address, one in found.items() if one}


def look_again(looks):
    """Has views look where they looked; what was closed meanwhile is left alone."""
    for address, values in looks.items():
        found = of_address(address)
        if found:
            for name, value in zip(_LOOK, values, strict=True):
                setattr(found[1].spaces.active.region_3d, name, value)


_LOOK = "view_perspective", "view_rotation", "view_location", "view_distance"


def _look(view):
    values = (getattr(view, name) for name in _LOOK)
    return [value if isinstance(value, (str, float)) else value.copy() for value in values]
