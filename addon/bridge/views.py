"""3D views: what each of them shows, and where it looks."""

from itertools import pairwise

import bpy
import numpy as np
from mathutils import Matrix

from ..core.framing import framed, free_span, upright
from ..core.refused import Refused
from .generative import evaluated
from .meshes import positions

SURROUNDINGS = 0.15  # of a mesh: so much of it is shown around a place
SENSOR = 72.0  # millimetres: what a view shows at a distance of its lens; Blender doubles the 36 of a camera


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

    The new view is the left one and shows the first side. ``frame`` them once they have ``settled``.
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
            _switch(context, area)
    if own and new:
        with context.temp_override(area=new, region=region_of(new)):
            bpy.ops.screen.area_close()


def _switch(context, area):
    """Local View on or off, at once: a view that is on its way cannot be framed."""
    preferences = context.preferences.view
    smooth, preferences.smooth_view = preferences.smooth_view, 0
    try:
        with context.temp_override(area=area, region=region_of(area)):
            bpy.ops.view3d.localview(frame_selected=True)
    finally:
        preferences.smooth_view = smooth


def _show_alone(context, area, objects):
    """Shows these objects and nothing else in a view; the selection stays as it was."""
    selected = {obj: obj.select_get() for obj in context.view_layer.objects}
    for obj in selected:
        obj.select_set(obj in objects)
    _switch(context, area)
    for obj, was in selected.items():
        obj.select_set(was)


def settled(addresses):
    """Whether Blender has drawn views since they were split: only then their regions know their sizes."""
    areas = [found[1] for found in map(of_address, addresses) if found]
    spans = sorted((area.x, area.x + area.width) for area in areas)
    apart = all(one[1] <= other[0] for one, other in pairwise(spans))
    inside = (
        area.x <= region.x and region.x + region.width <= area.x + area.width
        for area in areas
        for region in map(region_of, [area] * 2, ("WINDOW", "UI"))
        if region.width > 1
    )
    return apart and all(inside)


def frame(addresses):
    """Has each view that is in Local View show its meshes beside what covers it."""
    for window, area in filter(None, map(of_address, addresses)):
        space = area.spaces.active
        if space.local_view is not None:
            window.view_layer.update()
            meshes = (obj for obj in window.view_layer.objects if obj.type == "MESH")
            shown = [places(obj) for obj in meshes if obj.visible_get(viewport=space)]
            if any(map(len, shown)):
                look_at(area, np.concatenate(shown))


def places(obj):
    """(n, 3): where the vertices of a mesh object are seen, in the world."""
    shown = evaluated(obj)
    matrix = np.array(shown.matrix_world)
    return positions(shown.data.vertices) @ matrix[:3, :3].T + matrix[:3, 3]


def look_at(area, points, towards=None):
    """Has a view show points (k, 3) of the world where nothing covers it.

    ``towards`` (3,) is the way it looks, by default as it does.
    """
    region, data = region_of(area), area.spaces.active.region_3d
    if towards is not None:
        data.view_rotation = Matrix(upright(towards)).to_quaternion()
    covering = [
        (bar.x - region.x, bar.x - region.x + bar.width)
        for bar in (region_of(area, "UI"), region_of(area, "TOOLS"))
        if bar.width > 1
    ]
    size = region.width, region.height
    across = SENSOR / area.spaces.active.lens  # of the longer side of the region, at a distance of 1
    data.view_location, data.view_distance = framed(
        points,
        np.array(data.view_rotation.to_matrix()),
        size,
        free_span(region.width, covering),
        across / max(size),
        data.is_perspective,
    )


def show_places(context, objects, at, vertices, towards):
    """Has a view that shows some objects look at places (k, 3) with a part of the mesh (n, 3) around them.

    ``towards`` (3,) is the way to look. It is the own view before others; nothing where none shows them.
    """
    shown = [area for area in context.screen.areas if area.type == "VIEW_3D"] if context.screen else []
    shown.sort(key=lambda area: area != context.area)
    for area in shown:
        if all(obj.visible_get(viewport=area.spaces.active) for obj in objects):
            around = SURROUNDINGS * np.ptp(vertices, axis=0).max()
            ends = np.array([at.min(axis=0) - around, at.max(axis=0) + around])
            corners = np.array([ends[list(corner), range(3)] for corner in np.ndindex(2, 2, 2)])
            look_at(area, corners, towards)
            return


def swap(address, leaving, coming):
    """Has a view in Local View show one object in the place of another, or of None."""
    found = of_address(address)
    space = found and found[1].spaces.active
    if space and space.local_view is not None:
        if leaving is not None:
            leaving.local_view_set(space, False)
        coming.local_view_set(space, True)


def show_again(addresses, sides):
    """Has the two views of ``split`` show their sides, the own first, of which undo knows nothing."""
    for address, objects in zip(addresses or (), reversed(sides), strict=False):
        found = of_address(address)
        space = found and found[1].spaces.active
        if space and space.local_view is not None:
            for obj in objects:
                obj.local_view_set(space, True)


def written(addresses):
    """Which areas of which screen two views are, as text for a file, or ""."""
    found = [of_address(address) for address in addresses or ()]
    if not found or None in found:
        return ""
    places = (list(window.screen.areas).index(area) for window, area in found)
    return "\n".join([found[0][0].screen.name, *map(str, places)])


def read(text):
    """(window, addresses) of the views that ``written`` told of, or None where there are none such."""
    name, *places = text.split("\n")
    for window in bpy.context.window_manager.windows:
        areas = window.screen.areas
        if window.screen.name == name and all(int(place) < len(areas) for place in places):
            found = [areas[int(place)] for place in places]
            if all(area.type == "VIEW_3D" and area.spaces.active.local_view for area in found):
                return window, [area.as_pointer() for area in found]
    return None


def show_along(obj, other):
    """Has each Local View that shows an object show another one too."""
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            space = area.spaces.active
            if area.type == "VIEW_3D" and space.local_view is not None and obj.local_view_get(space):
                other.local_view_set(space, True)


def tool(context):
    """The name of the tool of 3D views in Object Mode, or None."""
    found = context.workspace.tools.from_space_view3d_mode("OBJECT", create=False)
    return found and found.idname


def take_tool(context, address, name):
    """Chooses the tool of the view at an address in Object Mode; nothing without a view or a name."""
    found = of_address(address)
    if found and name:
        window, area = found
        with context.temp_override(window=window, area=area, region=region_of(area)):
            bpy.ops.wm.tool_set_by_id(name=name)


def direction(area):
    """(3,): the way that a view looks."""
    return -np.array(area.spaces.active.region_3d.view_rotation.to_matrix())[:, 2]


class Linked:
    """Two views that look at two things alike: as one is turned, moved or zoomed, so is the other."""

    def __init__(self, addresses):
        """As the views look now, each shows its own thing as it should."""
        self._addresses = addresses
        self._home = self._last = self._states()

    def follow(self):
        """Has the view follow that was not touched since the last time; at first the second one."""
        now = self._states()
        if len(now) < 2 or all(map(same, now, self._last)):
            return
        leader = 1 if same(now[0], self._last[0]) else 0
        view = of_address(self._addresses[1 - leader])[1].spaces.active.region_3d
        home, other = self._home[leader], self._home[1 - leader]
        way, turn, location, distance = now[leader]
        scale = other[3] / home[3]
        view.view_perspective = "PERSP" if way == "CAMERA" else way
        view.view_rotation = turn
        view.view_location = other[2] + (location - home[2]) * scale
        view.view_distance = distance * scale
        self._last = self._states()

    def _states(self):
        return list(looks(self._addresses).values())


def same(one, other):
    """Whether two of the ``looks`` of a view are the same, but for rounding."""
    parts = ((np.array(a), np.array(b)) for a, b in zip(one[1:], other[1:], strict=True))
    return one[0] == other[0] and all(np.allclose(a, b, rtol=1e-5, atol=1e-6) for a, b in parts)


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
