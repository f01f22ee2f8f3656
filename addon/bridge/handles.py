"""Handles by name: a handle, its vertex group, its Empty and what refers to the group are renamed as one."""

import bpy

from ..core import names
from . import checks, empties


def rename(obj, handle, wanted):
    """Renames a handle of a mesh object with its vertex group; "" changes nothing."""
    wanted, old = wanted.strip(), handle.name
    group = obj.vertex_groups.get(old)
    if not wanted or wanted == old or group is None:
        return
    others = {*obj.vertex_groups.keys(), *obj.lissom_pose.handles.keys()} - {old}
    group.name = names.unused(wanted, others)
    new = group.name  # Blender may have cut it
    for row in obj.lissom_pose.company:  # what rides belongs to a handle by a group of the same name
        own = row.object.vertex_groups.get(old) if row.object is not None else None
        if own is not None and new not in row.object.vertex_groups:
            own.name = new
    if obj.lissom_pose.roi == old:
        obj.lissom_pose.roi = new
    for modifier in obj.modifiers:
        if getattr(modifier, "vertex_group", None) == old:
            modifier.vertex_group = new
    for other in bpy.data.objects:
        for constraint in other.constraints:
            if getattr(constraint, "target", None) == obj and getattr(constraint, "subtarget", "") == old:
                constraint.subtarget = new
    handle.name = new
    if empties.is_alive(handle.empty) and handle.empty.name == f"{obj.name} {old}":
        handle.empty.name = f"{obj.name} {new}"


def select(obj, handle):
    """Selects the Empty of a handle and nothing else, in Object Mode; one that was hidden is shown again."""
    layer = bpy.context.view_layer
    empty = handle.empty
    if bpy.context.mode != "OBJECT" or not empties.is_alive(empty) or empty.name not in layer.objects:
        return
    empty.hide_set(False)
    if not checks.is_shown(empty):  # by its collection, or in all views
        return
    for other in layer.objects:
        other.select_set(other == empty)
    layer.objects.active = empty


def row_of(obj):
    """(mesh object, row) of the handle whose Empty this object is; None where it is none."""
    mesh = obj.lissom_handle_of if obj is not None and obj.type == "EMPTY" else None
    if mesh is None:
        return None
    rows = [row for row, handle in enumerate(mesh.lissom_pose.handles) if handle.empty == obj]
    return (mesh, rows[0]) if rows else None
