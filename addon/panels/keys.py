"""What is made of the target's shape keys once they are there."""

import bpy

from .. import session
from ..bridge import shape_keys
from ..jobs.corrections import is_edited
from ..layouts import split_column
from ..translations import translated
from .common import draw_fold, draw_lines

SIDES = (("mirror", "MOD_MIRROR"), ("split", "SPLIT_VERTICAL"), ("sum", "ADD"))


class LISSOM_UL_learned(bpy.types.UIList):
    """How much each key would change by what is learned from the corrected ones."""

    bl_idname = "LISSOM_UL_learned"

    def draw_item(self, context, layout, data, item, icon, active_data, active_property):
        row = layout.row(align=True)
        row.label(text=item.name, translate=False, icon="SCULPTMODE_HLT" if item.corrected else "NONE")
        said = row.row()
        said.alignment = "RIGHT"
        told = f"{100 * item.change:.1f} %"
        if item.corrected:
            told = f"{max(0, 100 * item.foretold):.0f} % foretold"
        said.label(text=translated(told), translate=False)


def draw_sides(layout, obj):
    """Buttons of the active key of ``obj``: of its other side, of its halves, and the sum of keys."""
    for what, icon in SIDES:
        layout.operator(f"lissom.key_{what}", icon=icon).object = obj.name


def draw_made_keys(layout, settings):
    """A part of the panel, while the target has keys."""
    target = settings.target
    made = shape_keys.key_names(target)
    if not made:
        return
    body = draw_fold(layout, "made_keys", "Keys of the Target")
    if body:
        buttons = body.column(align=True)
        draw_sides(buttons, target)
        buttons.operator("lissom.key_strength", icon="FORCE_FORCE").object = target.name
        _draw_learning(body, settings, [name for name in made if is_edited(target, name)])


def _draw_learning(layout, settings, corrected):
    if not corrected:
        draw_lines(layout, "INFO", "Correct some keys by hand, and the others can learn from them")
        return
    split_column(layout).prop(settings, "learn_strength")
    row = layout.row(align=True)
    for preview in (True, False):
        text = "Preview" if preview else "Learn"
        icon = "HIDE_OFF" if preview else "LIGHT"
        button = row.operator("lissom.learn", text=text, icon=icon)
        button.object, button.strength = settings.target.name, settings.learn_strength
        button.preview = preview
    if session.learned:
        row.operator("lissom.learn_stop", text="", icon="X")
        layout.template_list("LISSOM_UL_learned", "", settings, "learned", settings, "active_learned", rows=6)


classes = (LISSOM_UL_learned,)
