"""A bound mesh object: what its settings ask for, and where its handles' Empties are."""

import bpy
import numpy as np

from ..core import pose as core_pose
from ..core import space, turns
from ..core.pose_options import Asked, options_of
from ..core.refused import Refused, first
from . import company, empties, mirrors, shape_keys, standing


def asked(settings):
    """Method and options as the settings of an object say."""
    options = settings.options

    def value(owner, name):
        return getattr(getattr(options, owner), name)

    return Asked.of(settings, options.multiresolution.base, value)


def is_adrift(settings):
    """Whether nothing holds the mesh but what is dragged: one handle, or such as were made on the mesh."""
    handles = settings.handles
    return not settings.roi and (len(handles) == 1 or all(handle.dragged for handle in handles))


def keep(settings, asked):
    """Writes method and options into the settings of an object, from which the file restores the pose."""
    for name in ("method", "use_weights", "weld", "symmetry", "stays", "reach"):
        setattr(settings, name, getattr(asked, name))
    for owner, name in options_of(asked.method, asked.options.get("base")):
        setattr(getattr(settings.options, owner), name, asked.options[name])


def linear_part(obj):
    """The (3, 3) part of the object's matrix that was applied at Bind."""
    return np.array(obj.lissom_pose.linear, dtype=np.float64).reshape(3, 3)


def rescaled(obj):
    """What to say where the object is stretched since Bind, which no turned handle can follow, or ""."""
    stretch = np.array(obj.matrix_world)[:3, :3] @ np.linalg.inv(linear_part(obj))
    if not np.isfinite(stretch).all():  # refused by whoever solves
        return ""
    values = np.linalg.svd(stretch, compute_uv=False)
    if values[0] <= 1.001 * values[2]:
        return ""
    return f"'{obj.name}' was scaled unevenly since Bind, and its handles with it: press Unbind, then Bind"


def hidden(obj):
    """What to say where the object does not show its live pose, or ""."""
    keys, name = obj.data.shape_keys, obj.lissom_pose.preview
    key = keys.key_blocks.get(name) if keys else None
    if key is None:  # refused by whoever solves
        return ""
    if obj.show_only_shape_key and obj.active_shape_key != key:
        return "Solo Active Shape Key is on, and shows another key than the pose: turn it off"
    if key.mute or not (obj.show_only_shape_key or key.value == 1):
        return f"Shape key '{name}', which shows the pose, is muted or not at 1"
    return ""


def preview(obj):
    """The shape key that shows the live pose."""
    return shape_keys.preview(obj, obj.lissom_pose.preview)


def to_drive(obj):
    """The name of the key that a bone is to drive: the last that Apply made, else the active one; or ""."""
    settings, keys = obj.lissom_pose, obj.data.shape_keys
    made = keys.key_blocks.get(settings.applied)
    if made is not None and not shape_keys.is_driven(made):
        return made.name
    active = obj.active_shape_key
    return "" if active in (None, keys.reference_key) or active.name == settings.preview else active.name


def left_out(obj):
    """Warnings about what is seen of the object and not in the shape that is posed."""
    said = mirrors.left_out(obj)
    if obj.lissom_pose.stood:
        return said
    keys, modifiers = standing.keys_on(obj), standing.deforming(obj)
    start = "The pose starts from the Basis: "
    if modifiers:
        moving = first(repr(modifier.name) for modifier in modifiers)
        said.insert(0, f"{start}modifier {moving} moves the mesh, not the Empties")
    if keys:
        said.insert(0, f"{start}shape key {first(map(repr, keys))} is on and adds to it")
    return said


def foreign_handles(obj):
    """Why the handles are not the object's own, or "": a copy of an object points at the same Empties."""
    foreign = [
        handle
        for handle in obj.lissom_pose.handles
        if empties.is_alive(handle.empty) and not owns(obj, handle)
    ]
    if not foreign:
        return ""
    listed = first(repr(handle.name) for handle in foreign)
    owner = foreign[0].empty.lissom_handle_of
    way = "press Unbind" if obj.lissom_pose.bound else "remove such handles"
    if owner is None:
        return f"What moves handle {listed} belongs to no mesh: {way}, then add them anew"
    return (
        f"What moves handle {listed} belongs to '{owner.name}', of which '{obj.name}' is a copy: {way}, "
        "then add them anew"
    )


def owns(obj, handle):
    """True where the Empty of a handle was made for this object and is still there."""
    return empties.is_alive(handle.empty) and handle.empty.lissom_handle_of == obj


def drop_foreign_handles(obj):
    """Takes handles off the list whose Empties are those of another object."""
    handles = obj.lissom_pose.handles
    for index in reversed(range(len(handles))):
        if empties.is_alive(handles[index].empty) and not owns(obj, handles[index]):
            handles.remove(index)
    obj.lissom_pose.active_handle = max(0, min(obj.lissom_pose.active_handle, len(handles) - 1))


def remove_preview(obj):
    """Takes the live pose off the mesh, unless it is that of another bound object with the same mesh."""
    settings, mesh = obj.lissom_pose, obj.data
    company.release(obj)
    for other in bpy.data.objects:
        theirs = other.lissom_pose
        shows = other != obj and other.data == mesh and theirs.bound and theirs.preview == settings.preview
        if shows and not foreign_handles(other):
            return
    if mesh.shape_keys and settings.preview in mesh.shape_keys.key_blocks:
        shape_keys.remove(obj, settings.preview)
    if settings.made_basis and mesh.shape_keys and len(mesh.shape_keys.key_blocks) == 1:
        obj.shape_key_clear()


def alive_handles(obj):
    """The handles of the object; Refused where an Empty was deleted or is another object's."""
    reason = foreign_handles(obj)
    if reason:
        raise Refused(reason)
    handles = obj.lissom_pose.handles
    lost = [handle.name for handle in handles if not empties.is_alive(handle.empty)]
    if lost:
        raise Refused(
            f"The Empty of handle {first(repr(name) for name in lost)} was deleted: "
            "undo that, or unbind, remove the handle and add it again"
        )
    return handles


def motion(obj, tracker=None):
    """Where the handles are now, as core.pose.Motion; a turns.Tracker goes with a row of frames."""
    handles, linear = alive_handles(obj), linear_part(obj)
    rest = np.array([handle.rest for handle in handles], dtype=np.float64).reshape(-1, 4, 4)
    posed = empties.matrices_in(obj, [handle.empty for handle in handles])
    transforms = space.handle_transforms(linear, rest, posed)
    if not np.isfinite(transforms).all():
        return core_pose.Motion(transforms)  # refused by whoever solves
    told = [
        empties.told_turn(obj, handle.empty, handle.rotation_mode, handle.rotation, linear, transform)
        for handle, transform in zip(handles, transforms, strict=True)
    ]
    extent = float(np.linalg.norm(obj.dimensions))
    moved = turns.only_moved(transforms, rest[:, :3, 3] @ linear.T, extent)
    by_itself = tuple(
        h for h, handle in enumerate(handles) if handle.turns_by_itself and moved[h] and told[h] is None
    )
    return core_pose.Motion(transforms, (tracker or turns.Tracker()).turns(transforms, told), by_itself)


def place_at_rest(obj):
    """Puts every handle's Empty back where it was at Bind."""
    space.linear_part(obj.matrix_world, obj.name)  # else Blender would misplace them for good
    for handle in obj.lissom_pose.handles:
        if owns(obj, handle):
            empties.place(obj, handle.empty, np.array(handle.rest).reshape(4, 4))
