"""Markers as numbered dots on both meshes, the two of a pair in one colour; what is hidden is hollow, what is
guessed is grey.
"""

from typing import NamedTuple

import blf
import bpy
import gpu

from .. import preferences, session
from ..bridge import picking
from ..core.marker_places import colour
from .handler import Drawn
from .shapes import ring

RIM = 1.5  # pixels
RING = 3.0  # pixels, between a mark and the ring around what a click would take
GUESSED = (0.6, 0.6, 0.6)


class Dot(NamedTuple):
    """A mark in a view: that of a pair that is begun has the place -1 in the list."""

    index: int
    number: int
    spot: tuple[float, float]
    hidden: bool


def shown(context):
    """The Dots of the marks that a view shows, the hidden ones first; context is that of its drawing."""
    settings = context.scene.lissom_transfer
    if not (session.picking or settings.show_markers) or None in (settings.source, settings.target):
        return []
    view = picking.view_of(context.region, context.region_data)
    graph = context.view_layer.depsgraph
    stage = picking.Stage(context.scene, graph, view, context.space_data, session.picking)
    marks = stage.marks(behind=not context.screen.is_animation_playing)
    dots = [Dot(mark.index, mark.number, spot, hidden) for mark, spot, hidden in marks]
    return sorted(dots, key=lambda dot: not dot.hidden)


def _draw():
    context = bpy.context
    dots, scale = shown(context), picking.ui_scale()
    if not dots and not session.picking:
        return
    radius, text = preferences.look()[:2]
    settings = context.scene.lissom_transfer
    active, guessed = settings.active_marker, [row.guessed for row in settings.markers] + [False]
    gpu.state.blend_set("ALPHA")
    for dot in dots:
        rgba = (*(GUESSED if guessed[dot.index] else colour(dot.number)), 1.0 if dot.index >= 0 else 0.5)
        rim = (1.0, 1.0, 1.0, 1.0) if dot.index == active else (0.05, 0.05, 0.05, 1.0)
        if dot.hidden:
            ring(dot.spot, (radius - 2 * RIM) * scale, (radius - RIM) * scale, (*rim[:3], 0.6))
            ring(dot.spot, (radius - RIM) * scale, radius * scale, rgba)
        else:
            ring(dot.spot, 0.0, (radius + RIM) * scale, rim)
            ring(dot.spot, 0.0, radius * scale, rgba)
    grabbed = session.picking and session.picking.ring
    if grabbed and grabbed[0] == context.region.as_pointer():
        inner = (radius + RIM + RING) * scale
        ring(grabbed[1], inner - RIM * scale, inner + 2 * RIM * scale, (0.05, 0.05, 0.05, 0.8))
        ring(grabbed[1], inner, inner + RIM * scale, (1.0, 1.0, 1.0, 1.0))
    blf.size(0, text * scale)
    blf.enable(0, blf.SHADOW)
    blf.shadow(0, 3, 0.0, 0.0, 0.0, 1.0)
    for dot in dots:
        blf.color(0, 1.0, 1.0, 1.0, 0.6 if dot.hidden else 1.0)
        blf.position(0, dot.spot[0] + 1.3 * radius * scale, dot.spot[1] + 0.7 * radius * scale, 0)
        blf.draw(0, str(dot.number))
    blf.disable(0, blf.SHADOW)
    gpu.state.blend_set("NONE")


_drawn = Drawn(_draw, "POST_PIXEL")
register, unregister = _drawn.register, _drawn.unregister
