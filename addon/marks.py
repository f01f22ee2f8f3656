"""Markers as numbered dots on both meshes: the two of a pair have one colour."""

import blf
import bpy
import gpu
import numpy as np
from gpu_extras.batch import batch_for_shader

from . import session
from .bridge import picking
from .bridge.markers import marks_of
from .core.marks import colour

RADIUS, RIM, TEXT = 5.5, 1.5, 12  # pixels
_TURN = np.linspace(0, 2 * np.pi, 17)
_CIRCLE = np.stack([np.cos(_TURN), np.sin(_TURN), 0 * _TURN], axis=1)

_handle = None


def shown(context):
    """(number, text, (r, g, b), (x, y)) of the marks that a view shows; context is that of its drawing."""
    settings, space = context.scene.lissom_transfer, context.space_data
    ends = {"source": settings.source, "target": settings.target}
    if not (session.picking or settings.show_markers) or None in ends.values():
        return
    depsgraph = context.view_layer.depsgraph
    meshes = {side: picking.shown_mesh(obj, depsgraph) for side, obj in ends.items()}
    visible = {side: obj.visible_get(viewport=space) for side, obj in ends.items()}
    for number, side, vertex in marks_of(context):
        place = visible[side] and picking.on_screen(
            ends[side], vertex, meshes[side], context.region, context.region_data
        )
        if place:
            count = number if number >= 0 else len(settings.markers)
            yield number, str(count + 1), colour(count), (place.x, place.y)


def _draw():
    found = list(shown(bpy.context))
    if not found:
        return
    scale = picking.ui_scale()
    active = bpy.context.scene.lissom_transfer.active_marker
    gpu.state.blend_set("ALPHA")
    for number, _, rgb, place in found:
        rim = (1.0, 1.0, 1.0, 1.0) if number == active else (0.05, 0.05, 0.05, 1.0)
        _disc(place, (RADIUS + RIM) * scale, rim)
        _disc(place, RADIUS * scale, (*rgb, 1.0 if number >= 0 else 0.4))
    blf.size(0, TEXT * scale)
    blf.enable(0, blf.SHADOW)
    blf.shadow(0, 3, 0.0, 0.0, 0.0, 1.0)
    blf.color(0, 1.0, 1.0, 1.0, 1.0)
    for _, text, _, (x, y) in found:
        blf.position(0, x + 1.3 * RADIUS * scale, y + 0.7 * RADIUS * scale, 0)
        blf.draw(0, text)
    blf.disable(0, blf.SHADOW)
    gpu.state.blend_set("NONE")


def _disc(place, radius, rgba):
    shader = gpu.shader.from_builtin("UNIFORM_COLOR")
    rim = np.array([*place, 0.0]) + radius * _CIRCLE
    corners = [(0, i, i + 1) for i in range(1, len(rim) - 1)]
    batch = batch_for_shader(shader, "TRIS", {"pos": rim.astype(np.float32)}, indices=corners)
    shader.uniform_float("color", rgba)
    batch.draw(shader)


def register():
    global _handle
    _handle = bpy.types.SpaceView3D.draw_handler_add(_draw, (), "WINDOW", "POST_PIXEL")


def unregister():
    global _handle
    bpy.types.SpaceView3D.draw_handler_remove(_handle, "WINDOW")
    _handle = None
