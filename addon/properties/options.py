"""Blender properties made of options."""

from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty

from ..core.options import option


def option_property(option, **also):
    """The Blender property of an option."""
    settings = {"name": option.label, "description": option.line, "default": option.default, **also}
    if option.items:
        items = [(*item, number) for number, item in enumerate(option.items)]
        return EnumProperty(items=items, **settings)
    if isinstance(option.default, bool):
        return BoolProperty(**settings)
    settings |= {"min": option.low, "max": option.high, "soft_max": option.soft_high or option.high}
    if option.precision is not None:
        settings["precision"] = option.precision
    return (IntProperty if isinstance(option.default, int) else FloatProperty)(**settings)


def iterations_property():
    """The most iterations of a solve."""
    return option_property(option("pose.solve", "max_iterations", "Iterations", low=1, high=100_000))
