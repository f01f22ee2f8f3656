"""One custom property that drives several shape keys, each by its hat function."""

import bpy

from ..core.refused import Refused
from . import shape_keys

SPAN = 1000  # of the time axis of a driver's curve


def data_path(slider):
    """The path of the custom property from its object."""
    return f'["{bpy.utils.escape_identifier(slider)}"]'


def check_name(obj, slider):
    """Refused where no custom property can have that name, or one with it would shadow Blender's own."""
    if not slider.strip() or not slider.isprintable():
        raise Refused(f"{slider!r:.80} is no name for a slider: use visible characters in one line")
    if slider in obj.bl_rna.properties:
        raise Refused(f"'{slider}' is a property of all objects: choose another name for the slider")


def add(obj, slider, description, value=0.0, limits=(0.0, 1.0)):
    """Makes the custom property, which a library override of the object may set."""
    obj[slider] = value
    obj.property_overridable_library_set(data_path(slider), True)
    obj.id_properties_ui(slider).update(
        min=limits[0],
        max=limits[1],
        soft_min=limits[0],
        soft_max=limits[1],
        default=0.0,
        description=description,
    )


def drive(block, path, obj, slider, corners):
    """Drives a property by the slider, along a curve through corners (core.easing.Corner).

    A curve that the artist can bend in the Drivers editor, of a product that Blender evaluates without
    Python: it plays where scripts are not allowed to run. Blender takes points of a curve that are closer
    than about 0.01 for one, so the curve lies over the slider in thousandths.
    """
    block.driver_remove(path)
    curve = block.driver_add(path)
    while curve.modifiers:  # 4.2 starts a driver with a generator, later versions with two points
        curve.modifiers.remove(curve.modifiers[0])
    curve.keyframe_points.clear()
    curve.keyframe_points.add(len(corners))
    for point, corner in zip(curve.keyframe_points, corners, strict=True):
        point.interpolation = "BEZIER"
        point.handle_left_type = point.handle_right_type = "FREE"
        point.co, point.handle_left, point.handle_right = ((SPAN * t, value) for t, value in corner)
    curve.extrapolation = "CONSTANT"
    curve.update()
    driver = curve.driver
    driver.type = "SCRIPTED"
    variable = driver.variables.new()
    variable.name = "slider"
    driver.expression = f"{SPAN} * slider"
    variable.targets[0].id = obj
    variable.targets[0].data_path = data_path(slider)


def take_over(obj, slider, start, end):
    """Start key on, end key off; the slider takes over how far the end key was on. Returns warnings."""
    warnings = []
    for key, value in ((start, 1.0), (end, 0.0)):
        if key == obj.data.shape_keys.reference_key:
            continue
        if _held(key):
            warnings.append(f"Shape key '{key.name}' is driven or locked: set it to {value:.0f} yourself")
            continue
        if key == end and end.value:
            obj[slider] = end.value
            obj.update_tag()
        key.value = value
    if start.mute:
        warnings.append(f"Shape key '{start.name}' is muted: the slider at 0 shows the mesh without it")
    return warnings


def hand_back(value, start, end):
    """The end key on as far as the slider was and the start key by the rest, where the slider took over."""
    own_start = start != start.id_data.reference_key
    if end.value or _held(end) or (own_start and (start.value != 1 or _held(start))):
        return
    end.value = value
    if own_start and end.relative_key != start:
        start.value = 1 - end.value


def _held(key):
    return key.lock_shape or shape_keys.is_driven(key)


def driven_keys(obj, slider, owners=None):
    """Names of the shape keys that the slider drives, in the order of the key list.

    ``owners`` are the objects whose slider counts, by default this one alone.
    """
    owners = owners or {obj}
    keys = obj.data.shape_keys
    if keys is None or keys.animation_data is None:
        return []
    path = data_path(slider)
    driven = {
        curve.data_path
        for curve in keys.animation_data.drivers
        for variable in curve.driver.variables
        if variable.targets[0].id in owners and variable.targets[0].data_path == path
    }
    return [key.name for key in keys.key_blocks if key.path_from_id("value") in driven]


def baked_keys(obj, slider):
    """Names of the keys that the arc of this slider made, driven by it: others are the artist's own.

    By name and by driver, for a name may have gone over to another key since; keys of an absolute arc have
    no drivers. A script's copy of object and mesh has its keys driven by the slider of the original, which
    does not use this mesh: they count too.
    """
    arc = obj.lissom_inbetween.arcs.get(slider)
    if arc is None:
        return []
    if arc.playback == "ABSOLUTE":
        keys = obj.data.shape_keys
        return [name for name in (keys.key_blocks.keys() if keys else []) if name in arc.keys]
    owners = {other for other in bpy.data.objects if other == obj or other.data != obj.data}
    return [name for name in driven_keys(obj, slider, owners) if name in arc.keys]
