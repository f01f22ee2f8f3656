"""Drive: a shape key that a bone drives, from 0 where it rests to 1 where it is now."""

from dataclasses import dataclass

import bpy

from ..bridge import bones, checks, shape_keys
from ..core.refused import Refused
from . import Asked, Done


@dataclass(kw_only=True)
class DriveAsked(Asked):
    """What is driven by what: names, "" for the active object and key, and the bone that moves most."""

    object: str = ""
    key: str = ""
    armature: str = ""
    bone: str = ""
    motion: str = "SWING"


@dataclass(kw_only=True)
class DriveDone(Done):
    """The names that were found."""

    key: str
    armature: str
    bone: str


def drive(context, asked):
    """Adds the driver; a DriveDone."""
    obj = checks.mesh_object(asked.object, context)
    checks.require_writable(obj)
    key = shape_keys.find(obj, asked.key) if asked.key else obj.active_shape_key
    if key is None or key == key.id_data.reference_key:
        raise Refused(f"Choose a shape key of '{obj.name}' other than the Basis first")
    shape_keys.refuse_preview(key)
    found = bones.likely(obj)
    rig = bpy.data.objects.get(asked.armature) if asked.armature else found and found[0]
    name = asked.bone or (found[1] if found else "")
    if rig is None:
        raise Refused(f"No armature moves '{obj.name}': name an armature and a bone")
    bone = bones.bone_of(rig, name)
    bones.drive(key, rig, bone, asked.motion)
    return DriveDone(
        summary=f"'{key.name}' follows the {asked.motion.lower()} of bone '{bone.name}'",
        warnings=[],
        key=key.name,
        armature=rig.name,
        bone=bone.name,
    )
