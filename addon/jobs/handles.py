"""Handles: what moves, before it is bound: added, removed and chosen, and further objects that go along."""

import bpy
import numpy as np
from mathutils import Vector

from ..bridge import checks, company, empties, groups, standing
from ..bridge import handles as bridge_handles
from ..core import space
from ..core.refused import Refused

EMPTY_SIZE = 0.04  # of the object's


def unbound(context, name=""):
    """The mesh object of that name, or the active one; Refused where it is bound or not to be written to."""
    obj = checks.mesh_object(name, context)
    if obj.mode != "EDIT":
        checks.require_writable(obj)
    if obj.lissom_pose.bound:
        raise Refused(f"'{obj.name}' is bound: press Unbind first, then change its handles")
    return obj


def add(context, name="", vertex_group=""):
    """A handle of a vertex group, by default a new one of the selected vertices; returns its row."""
    obj = unbound(context, name)
    space.linear_part(obj.matrix_world, obj.name)
    group = vertex_group or groups.from_selection(obj, "Handle")
    handles = obj.lissom_pose.handles
    if group in handles:
        raise Refused(f"'{group}' is a handle already")
    members = groups.members(obj, [group])
    if group not in members:
        raise Refused(f"'{obj.name}' has no vertex group named '{group}'")
    if not len(members[group]):
        raise Refused(f"Vertex group '{group}' holds no vertices: assign some, then add it")
    rest = standing.shown(obj)
    extent = np.ptp(space.into(np.array(obj.matrix_world)[:3, :3], rest), axis=0)
    size = EMPTY_SIZE * float(np.linalg.norm(extent)) or 1.0
    empty = empties.add(obj, f"{obj.name} {group}", Vector(rest[members[group]].mean(axis=0)), size)
    row = handles.add()
    row.name, row.empty = group, empty
    obj.lissom_pose.active_handle = len(handles) - 1
    obj.lissom_pose.property_unset("reach")
    return row


def remove(context, name="", handle=""):
    """Takes a handle, by default the active one, and its Empty away; the vertex group stays."""
    obj = unbound(context, name)
    settings = obj.lissom_pose
    index = settings.handles.find(handle) if handle else settings.active_handle
    if not 0 <= index < len(settings.handles):
        raise Refused(f"'{obj.name}' has no handle '{handle}'" if handle else "Choose a handle first")
    empty = settings.handles[index].empty
    if empty is not None and empty.lissom_handle_of == obj:
        bpy.data.objects.remove(empty)
    settings.handles.remove(index)
    settings.active_handle = max(0, min(settings.active_handle, len(settings.handles) - 1))
    settings.property_unset("reach")


def select(context, name, handle):
    """Selects the Empty of a handle."""
    obj = checks.mesh_object(name, context)
    row = obj.lissom_pose.handles.get(handle)
    if row is None or not empties.is_alive(row.empty):
        raise Refused(f"Handle '{handle}' has no Empty: remove the handle and add it again")
    if context.mode != "OBJECT":
        raise Refused("Go to Object Mode first")
    bridge_handles.select(obj, row)


def take_along(context, name=""):
    """Has the selected mesh objects go along with an object."""
    obj = unbound(context, name)
    others = [other for other in context.selected_objects if other.type == "MESH" and other != obj]
    if not others:
        raise Refused(f"Select the mesh objects that go along with '{obj.name}', then press again")
    for other in others:
        company.add(obj, other)


def leave_behind(context, name, place):
    """Takes the further object at a place of the list off it."""
    rows = unbound(context, name).lissom_pose.company
    if place >= len(rows):
        raise Refused(f"There is no further object {place}: there are {len(rows)}")
    rows.remove(place)
