"""What is made of the target's shape keys once they are there."""

from ..bridge import shape_keys
from .common import draw_fold

SIDES = (("mirror", "MOD_MIRROR"), ("split", "SPLIT_VERTICAL"), ("sum", "ADD"))


def draw_sides(layout, obj):
    """Buttons of the active key of ``obj``: of its other side, of its halves, and the sum of keys."""
    for what, icon in SIDES:
        layout.operator(f"lissom.key_{what}", icon=icon).object = obj.name


def draw_made_keys(layout, settings):
    """A part of the panel, while the target has keys."""
    target = settings.target
    if not shape_keys.key_names(target):
        return
    body = draw_fold(layout, "made_keys", "Keys of the Target")
    if body:
        draw_sides(body.column(align=True), target)
