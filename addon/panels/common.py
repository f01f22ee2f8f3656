"""What the panels share."""

from .. import session
from ..core.pose_options import options_of


class Sidebar:
    """Mixin: a panel in the tab "Lissom" of the 3D View's sidebar."""

    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Lissom"


def split_column(layout):
    """A column of settings in Blender's own manner: label to the left, no dots of animation."""
    column = layout.column()
    column.use_property_split = True
    column.use_property_decorate = False
    return column


def draw_options(column, method, base, owned):
    """The options of a pose method; ``owned(owner)`` has them as properties."""
    for (owner, name), option in options_of(method, base).items():
        data = owned(owner)
        if not option.when or getattr(data, option.when[0]) == option.when[1]:
            column.prop(data, name)


def draw_progress(layout, feature):
    """A bar while an operator of this feature (the middle of its name) is at work."""
    if session.work is not None and session.work_of.startswith(f"LISSOM_OT_{feature}"):
        fraction, stage = session.work.progress
        layout.progress(factor=fraction, text=f"{stage} (ESC cancels)")


def draw_lines(layout, icon, text, width=38):
    """A longer text over several lines; the first carries the icon, "NONE" for none."""
    column = layout.column(align=True)
    column.scale_y = 0.8
    line = ""
    for word in text.split():
        if line and len(line) + len(word) >= width:
            column.label(text=line, icon=icon)
            icon, line = "NONE" if icon == "NONE" else "BLANK1", word
        else:
            line = f"{line} {word}".strip()
    column.label(text=line, icon=icon)
