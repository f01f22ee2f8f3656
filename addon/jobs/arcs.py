"""What can be done with baked arcs: they are removed and renamed, and drawn as a contact sheet."""

from ..bridge import animation, arcs, checks, images, shape_keys, sheet, sliders
from ..core.refused import Refused, first


def arc_object(context, name):
    """The mesh object of that name, "" for the active one; Refused where no arc can be written to it."""
    obj = checks.mesh_object(name, context)
    arcs.require(obj)
    return obj


def remove(obj, slider):
    """Removes an arc with its keys and its slider; returns warnings."""
    arc = arcs.find(obj, slider)
    checks.require_unlocked([shape_keys.find(obj, name) for name in sliders.baked_keys(obj, slider)])
    start, end, rerouted = arc.start, arc.end, arc.reroute
    arcs.remove_keys(obj, slider)
    warnings = []
    keys = obj.data.shape_keys
    value = obj.get(slider)
    if rerouted and keys is not None and end in keys.key_blocks:
        path, back = sliders.data_path(slider), keys.key_blocks[end].path_from_id("value")
        left = animation.move(obj, path, keys, back)
        animation.redirect(obj, path, keys, back)
        if left:
            warnings.append(f"The animation of slider '{slider}' is not handed back: {left[0]}")
    if keys is not None and {start, end} <= set(keys.key_blocks.keys()) and isinstance(value, (int, float)):
        sliders.hand_back(value, keys.key_blocks[start], keys.key_blocks[end])
    images.take_away(obj, slider)
    if slider in obj:
        del obj[slider]
    orphans = sliders.driven_keys(obj, slider)
    if orphans:
        listed = first(repr(name) for name in orphans)
        warnings.append(f"The driver of shape key {listed} has lost its slider '{slider}'")
    return warnings


def rename(obj, slider, name):
    """Renames the slider of an arc, its keys, and what animates or reads it; returns warnings."""
    arc = arcs.find(obj, slider)
    if name == slider:
        return []
    sliders.check_name(obj, name)
    if name in obj:
        raise Refused(f"'{name}' is a custom property already: choose another name for the slider")
    baked = sliders.baked_keys(obj, slider)
    checks.require_unlocked([shape_keys.find(obj, key) for key in baked])
    description = obj.id_properties_ui(slider).as_dict().get("description", "") if slider in obj else ""
    times = [0.0, 1.0, *(key.time for key in arc.keys)]
    sliders.add(obj, name, description, obj.get(slider, 0.0), (min(times), max(times)))
    left = animation.move(obj, sliders.data_path(slider), obj, sliders.data_path(name))
    animation.redirect(obj, sliders.data_path(slider), obj, sliders.data_path(name))
    if slider in obj:
        del obj[slider]
    arc.name = name
    taken = set(obj.data.shape_keys.key_blocks.keys()) - set(baked)
    for made in arc.keys:
        if made.name in baked:
            key = shape_keys.find(obj, made.name)
            made.name = arcs.key_name(name, made.time, taken)
            taken.add(made.name)
            key.name = made.name
    return [f"The animation of slider '{slider}' stayed behind: {left[0]}"] if left else []


def draw_sheet(obj, names, path, steps, turn):
    """A picture of arcs beside the straight lines between their ends.

    ``names`` are those of their sliders, ``steps`` is the number of tiles in a row, ``turn`` how many degrees
    it looks from the side.
    """
    times = [step / (steps - 1) for step in range(steps)]
    rows = []
    for slider in names:
        shapes = arcs.played(obj, slider, times)
        lines = [(1 - t) * shapes[0] + t * shapes[-1] for t in times]
        for label, row in ((slider, shapes), ("straight", lines)):
            tiles = [(f"{100 * t:.0f} %", shape) for t, shape in zip(times, row, strict=True)]
            rows.append((label, tiles))
    sheet.render(obj, rows, path, turn=turn)
