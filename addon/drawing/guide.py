"""The small picture of the landmarks while they are picked: those that are marked, and the one asked for."""

import blf
import bpy
import gpu
import numpy as np

from .. import session
from ..bridge import picking
from ..core.landmarks import SETS, picture
from ..translations import translated
from .handler import Drawn
from .shapes import box, line, ring

SIZE, MARGIN, BORDER, TEXT = 170, 24, 14, 13  # pixels
GROUND, LINES = (0.06, 0.06, 0.06, 0.75), (0.62, 0.62, 0.62, 1.0)
DONE, OPEN, WANTED = (0.35, 0.75, 0.40, 1.0), (0.62, 0.62, 0.62, 1.0), (1.0, 0.62, 0.12, 1.0)


def _draw():
    picked, settings = session.picking, bpy.context.scene.lissom_transfer
    landmarks = SETS.get(settings.landmarks)
    if picked is None or not landmarks:
        return
    scale = picking.ui_scale()
    low = MARGIN * scale * np.ones(2)
    size, border = SIZE * scale, BORDER * scale
    middle = low + border + size / 2
    gpu.state.blend_set("ALPHA")
    box(low, low + size + 2 * border, GROUND)
    for spots in picture(settings.landmarks):
        line(middle + np.array(spots) / 100 * size, LINES)
    marked = {row.name for row in settings.markers if not row.guessed}
    for landmark in landmarks:
        spot = middle + np.array(landmark.spot) / 100 * size
        if landmark.name == picked.wanted:
            ring(spot, 0.0, 5.5 * scale, WANTED)
            ring(spot, 8.0 * scale, 9.5 * scale, WANTED)
        else:
            ring(spot, 0.0, 2.5 * scale, DONE if landmark.name in marked else OPEN)
    blf.size(0, TEXT * scale)
    blf.color(0, 1.0, 1.0, 1.0, 1.0)
    blf.position(0, low[0] + border, low[1] + size + 2 * border + 6 * scale, 0)
    blf.draw(0, translated(picked.wanted or "All landmarks are marked"))
    gpu.state.blend_set("NONE")


_drawn = Drawn(_draw, "POST_PIXEL")
register, unregister = _drawn.register, _drawn.unregister
