"""The arc as a ghost in the viewport, while its ends are being chosen.

A few steps of the path are computed beside Blender, once per choice, and drawn as translucent surfaces over
the active mesh. Nothing is written to the scene; nothing is computed while the ghost is off.
"""

import bpy
import gpu
import lissom
import numpy as np
from bpy.app.handlers import persistent
from gpu_extras.batch import batch_for_shader

from .. import changes, preferences
from ..bridge import arcs, checks
from ..bridge.screen import redraw_sidebars, redraw_views
from ..core.inbetween import ArcAsked
from ..core.refused import Refused
from .handler import Drawn

STEPS = 5
LARGE, STEPS_LARGE = 200_000, 1  # from so many vertices on, the middle alone
HUGE = 1_000_000  # from so many on, none
POLL_SECONDS = 0.05
LIGHT = np.array([0.35, -0.70, 0.62])

_ghosts = {}  # session_uid of a mesh object -> Ghost


class Ghost:
    """The ghost of one object: at work, then steps to draw, or a message why there are none."""

    def __init__(self, obj):
        self.message, self.steps, self._batches, self._look = "", [], None, None
        self._work = None
        try:
            self._start(obj)
        except (Refused, lissom.Error) as error:
            self.message = str(error)

    def _start(self, obj):
        count = len(obj.data.vertices)
        if count >= HUGE:
            raise Refused(f"No ghost: {count} vertices are too many to draw several times over")
        if not obj.lissom_inbetween.end:
            raise Refused("Choose the shape key that the arc leads to")
        steps = STEPS if count < LARGE else STEPS_LARGE
        asked = ArcAsked.of(obj.lissom_inbetween, sampling="COUNT", count=steps)
        self._ends = arcs.Ends(obj, asked)
        self._work = self._ends.path(asked)

    def poll(self):
        """True while it is at work."""
        if self._work is None:
            return False
        try:
            if not self._work.poll():
                return True
            self._take(self._work.result)
        except (Refused, lissom.Error) as error:
            self.message = str(error)
        self._work = None
        return False

    def wait(self):
        """Computes to the end: background mode."""
        if self._work is not None:
            self._take(self._work.wait())
            self._work = None

    def cancel(self):
        """Stops its work."""
        if self._work is not None:
            self._work.cancel()
            self._work = None

    def _take(self, sampled):
        mesh = self._ends.mesh
        self.triangles = mesh.triangles
        for time, shape in zip(sampled.knots[1:-1], self._ends.back(sampled.shapes[1:-1]), strict=True):
            self.steps.append((time, shape.astype(np.float32), _light(shape, mesh.triangles)))

    def draw(self):
        """Draws the steps, in the object's own coordinates."""
        shader = gpu.shader.from_builtin("SMOOTH_COLOR")
        look = preferences.look()
        if self._look != look:  # only here is there a graphics card
            indices = self.triangles.astype(np.int32)
            self._batches = [
                batch_for_shader(
                    shader, "TRIS", {"pos": shape, "color": _colours(look, time, light)}, indices=indices
                )
                for time, shape, light in self.steps
            ]
            self._look = look
        for batch in self._batches:  # of every step only its front, so that it shows as one layer
            gpu.state.color_mask_set(False, False, False, False)
            gpu.state.depth_mask_set(True)
            batch.draw(shader)
            gpu.state.color_mask_set(True, True, True, True)
            gpu.state.depth_mask_set(False)
            batch.draw(shader)


def ask(obj):
    """Has the ghost of a mesh object computed anew, or forgotten where it is off."""
    if not obj.lissom_inbetween.ghost:
        if of(obj) is not None:
            drop(obj)
        return
    drop(obj)
    ghost = _ghosts[obj.session_uid] = Ghost(obj)
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


def _light(shape, triangles):
    """(n,): how much light each vertex gets from one side."""
    a, b, c = (shape[column] for column in triangles.T)
    faces = np.cross(b - a, c - a)
    normals = np.stack(
        [sum(np.bincount(column, faces[:, i], len(shape)) for column in triangles.T) for i in range(3)],
        axis=1,
    )
    lengths = np.linalg.norm(normals, axis=1)
    return 0.675 + 0.325 * (normals @ LIGHT) / np.where(lengths > 0, lengths, 1.0)


def _colours(look, time, light):
    """(n, 4) float32: the colour of a time on the arc, as it is lit."""
    colours = np.empty((len(light), 4), dtype=np.float32)
    blend = (1 - time) * np.array(look.ghost_start) + time * np.array(look.ghost_end)
    colours[:, :3] = blend * light[:, None]
    colours[:, 3] = look.ghost_opacity
    return colours


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
    if ghost is None or not ghost.steps or not obj.lissom_inbetween.ghost or not obj.visible_get():
        return
    gpu.state.blend_set("ALPHA")
    gpu.state.depth_test_set("LESS_EQUAL")
    gpu.matrix.push()
    gpu.matrix.multiply_matrix(obj.matrix_world)
    try:
        ghost.draw()
    finally:
        gpu.matrix.pop()
        gpu.state.color_mask_set(True, True, True, True)
        gpu.state.depth_mask_set(False)
        gpu.state.depth_test_set("NONE")
        gpu.state.blend_set("NONE")


_drawn = Drawn(_draw, "POST_VIEW")


@persistent
def _on_load(*_):
    for ghost in _ghosts.values():
        ghost.cancel()
    _ghosts.clear()


def register():
    _drawn.register()
    bpy.app.handlers.load_pre.append(_on_load)
    changes.arc_choice.append(ask)


def unregister():
    bpy.app.handlers.load_pre.remove(_on_load)
    changes.arc_choice.remove(ask)
    if bpy.app.timers.is_registered(_poll):
        bpy.app.timers.unregister(_poll)
    _drawn.unregister()
    _on_load()
