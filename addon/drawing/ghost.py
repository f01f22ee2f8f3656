"""The arc as a ghost in the viewport, while its ends are being chosen.

Outlines of a few steps and trails of what moves most, over the active mesh; and one shape as a translucent
surface, at the place of *Preview At*. Nothing is written to the scene, and no key is touched.
"""

import bpy
import gpu
import numpy as np
from bpy.app.handlers import persistent
from gpu_extras.batch import batch_for_shader
from mathutils import Matrix

from .. import changes, preferences
from ..bridge import arcs, checks
from ..bridge.picking import ui_scale
from ..bridge.screen import redraw_sidebars, redraw_views
from ..core.ghost import light, normals
from ..jobs.ghost import Ghost
from .handler import Drawn

POLL_SECONDS = 0.05
OUTLINE, TRAIL = 1.6, 2.2  # widths in pixels
LINES = 0.9  # opacity of lines, where nothing hides them
HIDDEN = 0.3  # and behind the mesh
VIEWS = 4  # 3D views whose outlines are kept
NEARER = Matrix.Diagonal((1.0, 1.0, 0.01, 1.0))  # all depths lie in a hundredth in front
NEARER[2][3] = -0.98

_ghosts = {}  # session_uid of a mesh object -> Pictured


class Pictured(Ghost):
    """A ghost with what the graphics card has of it, which is there only where it is drawn."""

    def __init__(self, obj):
        super().__init__(obj)
        self._look = None

    def draw(self, eye, slider, easing):
        """Draws it in the object's own coordinates; ``eye`` is that of ``outlines``, ``slider`` of ``at``."""
        look = preferences.look()
        if self._look != look:
            self._look, self._outlines, self._solid = look, {}, (None, None)
            self._trails = _strips(look, self.times, self.trails)
        self._draw_outlines(eye)
        if slider > 0:
            self._draw_solid(*self.at(slider, easing))
        gpu.state.depth_test_set("NONE")
        self._trails.draw(_polyline("SMOOTH", TRAIL))

    def _draw_outlines(self, eye):
        if eye not in self._outlines:
            while len(self._outlines) >= VIEWS:
                del self._outlines[next(iter(self._outlines))]
            line = gpu.shader.from_builtin("POLYLINE_UNIFORM_COLOR")
            self._outlines[eye] = [
                (
                    _colour(self._look, time),
                    batch_for_shader(line, "LINES", {"pos": np.float32(pieces.reshape(-1, 3))}),
                )
                for time, pieces in self.outlines(np.array(eye))
                if len(pieces)
            ]
        for test, opacity in (("GREATER", HIDDEN), ("LESS_EQUAL", LINES)):
            gpu.state.depth_test_set(test)
            for colour, batch in self._outlines[eye]:
                line = _polyline("UNIFORM", OUTLINE)
                line.uniform_float("color", (*colour, opacity))
                batch.draw(line)

    def _draw_solid(self, shape, time):
        """In front of the mesh, whose shape it is seen in place of, but not of itself."""
        shader = gpu.shader.from_builtin("SMOOTH_COLOR")
        if self._solid[0] != time:
            colours = np.empty((len(shape), 4), dtype=np.float32)
            lit = light(normals(shape, self.triangles))
            colours[:, :3], colours[:, 3] = lit[:, None] * _colour(self._look, time), self._look.ghost_opacity
            batch = batch_for_shader(
                shader, "TRIS", {"pos": shape, "color": colours}, indices=self.triangles.astype(np.int32)
            )
            self._solid = time, batch
        gpu.state.depth_test_set("LESS_EQUAL")
        gpu.matrix.push_projection()
        gpu.matrix.load_projection_matrix(NEARER @ gpu.matrix.get_projection_matrix())
        try:
            for colour in (False, True):  # of what lies behind each other only the front, as one layer
                gpu.state.color_mask_set(colour, colour, colour, colour)
                gpu.state.depth_mask_set(not colour)
                self._solid[1].draw(shader)
        finally:
            gpu.matrix.pop_projection()
            gpu.state.color_mask_set(True, True, True, True)
            gpu.state.depth_mask_set(False)


def ask(obj):
    """Has the ghost of a mesh object computed anew, or forgotten where it is off."""
    if not obj.lissom_inbetween.ghost:
        obj.lissom_inbetween.property_unset("preview")
        if of(obj) is not None:
            drop(obj)
        return
    drop(obj)
    ghost = _ghosts[obj.session_uid] = Pictured(obj)
    if bpy.app.background:  # timers do not run
        ghost.wait()
    elif not bpy.app.timers.is_registered(_poll):
        bpy.app.timers.register(_poll, first_interval=POLL_SECONDS)


def drop(obj):
    """Forgets the ghost of an object."""
    ghost = _ghosts.pop(obj.session_uid, None)
    if ghost is not None:
        ghost.cancel()
    redraw_views()


def of(obj):
    """The ghost of an object, or None."""
    return _ghosts.get(obj.session_uid)


def eye_of(view, obj):
    """(x, y, z, w) of the eye of a RegionView3D in an object's coordinates: a direction where w is 0."""
    column = view.view_matrix.inverted().col[3 if view.is_perspective else 2]
    return tuple(obj.matrix_world.inverted_safe() @ column)


def _colour(look, time):
    """(3,): the colour of a time on the arc."""
    return (1 - time) * np.array(look.ghost_start) + time * np.array(look.ghost_end)


def _strips(look, times, trails):
    """A batch of (c, k, 3) trails, each from the colour of the start to that of the end."""
    count, length = trails.shape[:2]
    colours = np.ones((count, length, 4), dtype=np.float32)
    colours[..., :3] = [_colour(look, time) for time in times]
    pairs = np.arange(count * length).reshape(count, length)
    pieces = np.stack([pairs[:, :-1], pairs[:, 1:]], axis=-1).ravel()
    places = {"pos": np.float32(trails.reshape(-1, 3)[pieces]), "color": colours.reshape(-1, 4)[pieces]}
    return batch_for_shader(gpu.shader.from_builtin("POLYLINE_SMOOTH_COLOR"), "LINES", places)


def _polyline(kind, width):
    """Blender's shader of lines as wide as this."""
    shader = gpu.shader.from_builtin(f"POLYLINE_{kind}_COLOR")
    shader.uniform_float("viewportSize", gpu.state.viewport_get()[2:])
    shader.uniform_float("lineWidth", width * ui_scale())
    return shader


def _poll():
    working = [ghost.poll() for ghost in _ghosts.values()]
    if any(working):
        return POLL_SECONDS
    redraw_views()
    redraw_sidebars()
    return None


def _draw():
    obj = checks.active_mesh(bpy.context)
    ghost = of(obj) if obj is not None else None
    settings = obj.lissom_inbetween if obj is not None else None
    if ghost is None or ghost.shapes is None or not settings.ghost or not obj.visible_get():
        return
    if arcs.missing(obj, settings):
        return
    gpu.state.blend_set("ALPHA")
    gpu.matrix.push()
    gpu.matrix.multiply_matrix(obj.matrix_world)
    try:
        ghost.draw(eye_of(bpy.context.region_data, obj), settings.preview, settings.easing)
    finally:
        gpu.matrix.pop()
        gpu.state.depth_test_set("NONE")
        gpu.state.blend_set("NONE")


_drawn = Drawn(_draw, "POST_VIEW")


@persistent
def _before_load(*_):
    for ghost in _ghosts.values():
        ghost.cancel()
    _ghosts.clear()


@persistent
def _after_load(*_):
    """A file that was saved with a ghost on shows it again."""
    for obj in bpy.data.objects:
        if obj.type == "MESH" and obj.lissom_inbetween.ghost:
            ask(obj)


_HANDLERS = (("load_pre", _before_load), ("load_post", _after_load))


def register():
    _drawn.register()
    for event, handler in _HANDLERS:
        getattr(bpy.app.handlers, event).append(handler)
    changes.arc_choice.append(ask)
    changes.arc_preview.append(redraw_views)


def unregister():
    changes.arc_preview.remove(redraw_views)
    changes.arc_choice.remove(ask)
    for event, handler in _HANDLERS:
        getattr(bpy.app.handlers, event).remove(handler)
    if bpy.app.timers.is_registered(_poll):
        bpy.app.timers.unregister(_poll)
    _drawn.unregister()
    _before_load()
