"""What panels and the redo panels of operators draw alike, and the tab that they are in."""

from .core.pose_options import options_of

TAB = "Lissom"


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
