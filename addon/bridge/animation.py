"""Drivers and animation curves of one property, moved to another.

Where a curve lies in the file changed with 4.4: an action has slots, and each its bag of curves.
"""

import contextlib

import bpy

_PLACES = ("co", "handle_left", "handle_right")
_KINDS = ("interpolation", "easing", "handle_left_type", "handle_right_type", "type")


def driver(block, path):
    """The driver of a property of an ID, or None."""
    data = block.animation_data
    return data.drivers.find(path) if data else None


def curve(block, path):
    """The animation curve of a property of an ID in its own action, or None."""
    curves = _curves(block)
    return curves.find(path) if curves is not None else None


def driven_by(block, path, source, source_path):
    """True where the driver of a property of an ID reads a property of another."""
    found = driver(block, path)
    variables = found.driver.variables if found is not None else ()
    return any(_reads(variable, source, source_path) for variable in variables)


def in_nla(block, path):
    """True where a strip of non-linear animation moves the property."""
    data = block.animation_data
    strips = (strip for track in data.nla_tracks for strip in track.strips) if data else ()
    return any(
        found.data_path == path for strip in strips if strip.action for found in _all_curves(strip.action)
    )


def move(block, path, target, target_path):
    """Moves driver and curve of a property to another; returns reasons for what had to stay where it is."""
    left = []
    source = curve(block, path)
    if source is not None:
        action = block.animation_data.action
        if curve(target, target_path) is not None:
            left.append("the other is animated already")
        elif _users(block.animation_data) > 1 or not action.is_editable:
            left.append(f"action '{action.name}' is used by others too")
        elif not len(source.keyframe_points):
            left.append("its curve has samples in place of keyframes")
        else:
            _copy(source, target, target_path)
            _curves(block).remove(source)
    source = driver(block, path)
    if source is not None:
        if driver(target, target_path) is not None:
            left.append("the other has a driver of its own")
        elif any(_reads(variable, target, target_path) for variable in source.driver.variables):
            left.append("its driver reads the other")
        else:
            data = target.animation_data or target.animation_data_create()
            data.drivers.from_existing(src_driver=source).data_path = target_path
            block.driver_remove(path)
    if in_nla(block, path):
        left.append("a strip of non-linear animation holds it")
    return left


def remove(block, path):
    """Takes driver and animation curve off a property."""
    block.driver_remove(path)
    remove_curve(block, path)


def remove_curve(block, path):
    """Takes the animation curve off a property."""
    found = curve(block, path)
    if found is not None:
        _curves(block).remove(found)


def copy_driver(block, path, target, target_path, instead, paths):
    """Copies the driver of a property, if it has one, to another; reads ``instead`` of one ID another.

    ``instead`` has pairs of IDs, ``paths`` says what a path of ``block`` is called on ``target``. A custom
    property that the copy then misses comes along. Returns what it still reads at its old place, since the
    new one has nothing like it.
    """
    source = driver(block, path)
    if source is None:
        return []
    target.driver_remove(target_path)
    data = target.animation_data or target.animation_data_create()
    made = data.drivers.from_existing(src_driver=source)
    made.data_path = target_path
    left = []
    for variable in made.driver.variables:
        for goal in variable.targets:
            other = next((other for one, other in instead if one is not None and goal.id == one), None)
            if other is None:
                continue
            there = paths.get(goal.data_path, goal.data_path) if goal.id == block else goal.data_path
            if variable.type == "SINGLE_PROP":
                _bring_property(goal.id, other, there)
                if not _has(other, there):
                    left.append(f"{there} of '{goal.id.name}'")
                    continue
            goal.id, goal.data_path = other, there
    return left


def _has(block, path):
    try:
        block.path_resolve(path)
    except ValueError:
        return False
    return True


def _bring_property(one, other, path):
    for name in list(one.keys()):
        if path.startswith(f'["{bpy.utils.escape_identifier(name)}"]') and name not in other:
            other[name] = one[name]
            with contextlib.suppress(TypeError):  # a group or text has none
                other.id_properties_ui(name).update_from(one.id_properties_ui(name))


def redirect(block, path, target, target_path):
    """Has every driver that reads one property read the other."""
    kind = "OBJECT" if isinstance(target, bpy.types.Object) else "KEY"
    for reader in _blocks_with_drivers():
        for found in reader.animation_data.drivers:
            for variable in found.driver.variables:
                if _reads(variable, block, path):
                    source = variable.targets[0]
                    source.id_type = kind
                    source.id = target
                    source.data_path = target_path


def _reads(variable, block, path):
    source = variable.targets[0]
    return variable.type == "SINGLE_PROP" and source.id == block and source.data_path == path


def _curves(block):
    data = block.animation_data
    if data is None or data.action is None:
        return None
    if not hasattr(data, "action_slot"):
        return data.action.fcurves
    if data.action_slot is None:
        return None
    bags = [strip.channelbag(data.action_slot) for layer in data.action.layers for strip in layer.strips]
    return next((bag.fcurves for bag in bags if bag is not None), None)


def _users(data):
    """How many IDs play the curves of an animated ID; an action's other slots are the affair of others."""
    return len(data.action_slot.users()) if hasattr(data, "action_slot") else data.action.users


def _all_curves(action):
    if not hasattr(action, "layers"):
        return action.fcurves
    bags = (bag for layer in action.layers for strip in layer.strips for bag in strip.channelbags)
    return (found for bag in bags for found in bag.fcurves)


def _copy(source, target, path):
    target.keyframe_insert(path, frame=source.keyframe_points[0].co.x)  # makes action, slot and curve
    made = curve(target, path)
    made.keyframe_points.clear()
    made.keyframe_points.add(len(source.keyframe_points))
    for old, new in zip(source.keyframe_points, made.keyframe_points, strict=True):
        for name in (*_KINDS, "amplitude", "back", "period", *_PLACES):
            setattr(new, name, getattr(old, name))
    for old in source.modifiers:
        new = made.modifiers.new(old.type)
        _copy_properties(old, new)
    made.extrapolation, made.mute, made.lock = source.extrapolation, source.mute, source.lock
    made.update()


def _copy_properties(old, new):
    for prop in old.bl_rna.properties:
        if not prop.is_readonly and prop.type != "COLLECTION":
            setattr(new, prop.identifier, getattr(old, prop.identifier))


def _blocks_with_drivers():
    for prop in bpy.data.bl_rna.properties:
        if prop.type == "COLLECTION":
            for block in getattr(bpy.data, prop.identifier):
                # A material's nodes are a block of their own that no list holds.
                for part in filter(None, (block, getattr(block, "node_tree", None))):
                    data = getattr(part, "animation_data", None)
                    if data is not None and len(data.drivers) and block.is_editable:
                        yield part
