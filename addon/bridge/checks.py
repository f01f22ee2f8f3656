"""What an object must be for Lissom to write to it (rows 34 to 36); used by poll() and by execute() alike."""

import bpy

from ..core.refused import Refused, first


def mesh_object(name, context):
    """The mesh object of that name; for "" the one that ``active_mesh`` finds."""
    if name:
        obj = bpy.data.objects.get(name)
        if obj is None:
            raise Refused(f"There is no object named '{name}'")
    else:
        obj = active_mesh(context)
        if obj is None:
            raise Refused("Select a mesh object first")
    return require_mesh(obj)


def by_uid(uid):
    """The object of a session_uid, whatever it is called now, or None."""
    return next((obj for obj in bpy.data.objects if obj.session_uid == uid), None)


def require_mesh(obj):
    """The object; Refused where it is none of a mesh."""
    if obj.type != "MESH":
        raise Refused(f"Object '{obj.name}' is no mesh: choose a mesh object")
    return obj


def active_mesh(context):
    """The mesh object that the artist is working on, or None: a handle's Empty stands for its mesh."""
    obj = context.object
    if obj is not None and obj.type == "EMPTY" and obj.lissom_handle_of is not None:
        obj = obj.lissom_handle_of
    return obj if obj is not None and obj.type == "MESH" else None


def is_shown(obj):
    """Whether the view layer shows an object; a view may leave it out in its Local View."""
    with bpy.context.temp_override(area=None):
        return obj.visible_get()


def refusal(obj, keys=True):
    """Why nothing can be written to a mesh object, or "". With ``keys``: to its shape keys."""
    mesh = obj.data
    for kind, block in (("Object", obj), ("The mesh of", mesh), ("The shape keys of", mesh.shape_keys)):
        if block is None:
            continue
        if block.override_library is not None:
            return f"{kind} '{obj.name}' is a library override: make it local first (Object > Relations)"
        if block.library is not None or not block.is_editable:
            return (
                f"{kind} '{obj.name}' is linked from another file: make it local first (Object > Relations)"
            )
    if obj.mode != "OBJECT":
        return f"'{obj.name}' is in {obj.mode.replace('_', ' ').lower()} mode: go to Object Mode first"
    if keys and mesh.shape_keys and not mesh.shape_keys.use_relative:
        return f"The shape keys of '{obj.name}' are absolute: turn on Relative in its Shape Keys panel"
    return ""


def require_writable(obj, keys=True):
    """Raises what ``refusal`` says."""
    reason = refusal(obj, keys)
    if reason:
        raise Refused(reason)


def require_unlocked(keys):
    """Refused where one of these shape keys is locked."""
    locked = [key.name for key in keys if key.lock_shape]
    if locked:
        listed = first(repr(name) for name in locked)
        one = len(locked) == 1
        raise Refused(
            f"Shape key{'' if one else 's'} {listed} {'is' if one else 'are'} locked: "
            f"unlock {'it' if one else 'them'} in the list of shape keys"
        )


def require_own_mesh(obj, owners):
    """Refuses an object whose mesh is that of another among {mesh: object}, and adds it to them."""
    other = owners.setdefault(obj.data, obj)
    if other != obj:
        raise Refused(
            f"'{other.name}' and '{obj.name}' have one mesh in common: give each its own first "
            "(Object > Relations > Make Single User)"
        )


def shared_data(obj, what="shape keys"):
    """A warning where other objects use the same mesh data and will change too, or ""."""
    users = sum(1 for other in bpy.data.objects if other.data is obj.data)
    if users < 2:
        return ""
    return f"The mesh of '{obj.name}' is used by {users} objects: all of them get the same {what}"
