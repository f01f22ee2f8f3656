"""A shape key driven by a bone: 0 where the bone rests, 1 where it is now."""

from math import asin, pi

from mathutils import Quaternion

from ..core.refused import Refused
from . import animation

LEAST = 0.01  # radians
MOST = pi - 0.05  # a driver's angles jump at half a turn


def bone_of(rig, name):
    """The pose bone of that name; Refused where there is none."""
    bone = rig.pose.bones.get(name) if rig is not None and rig.type == "ARMATURE" else None
    if bone is None:
        raise Refused(f"There is no bone '{name}': choose an armature and one of its bones")
    return bone


def likely(obj):
    """(armature object, name) of the bone of an object's armature that is turned furthest, or None."""
    found = []
    for modifier in obj.modifiers:
        rig = modifier.object if modifier.type == "ARMATURE" else None
        bones = rig.pose.bones if rig is not None else ()
        own = [bone for bone in bones if bone.name in obj.vertex_groups]
        found += [(abs(_local(rig, bone).angle), rig, bone.name) for bone in own]
    best = max(found, key=lambda one: one[0], default=None)
    return best and best[1:]


def drive(key, rig, bone, motion):
    """Drives the value of a key by the ``motion`` of a bone, "SWING" or "TWIST", from its rest to now.

    Swing counts along the way that the bone has swung now: one bent the other way leaves the key at 0.
    The driver is an expression that Blender evaluates without Python.
    """
    turned = _local(rig, bone)
    told = (0.0, 0.0, 0.0) if bone.rotation_mode in ("QUATERNION", "AXIS_ANGLE") else bone.rotation_euler
    if max(abs(turned.angle), *map(abs, told)) > MOST:
        raise Refused(f"Bone '{bone.name}' turns by half a turn or more, where drivers jump: turn it by less")
    swing, twist = turned.to_swing_twist("Y")
    if motion == "TWIST":
        channels = {"twist": ("ROT_Y", twist)}
    else:
        # What Blender takes for the angles of a swing (fcurve_driver.cc).
        channels = {"x": ("ROT_X", 2 * asin(swing.x)), "z": ("ROT_Z", 2 * asin(swing.z))}
    squared = sum(value**2 for _, value in channels.values())
    if squared < LEAST**2:
        raise Refused(
            f"Bone '{bone.name}' does not {motion.lower()} now: pose it as the key is for, then press again"
        )
    path = key.path_from_id("value")
    if animation.curve(key.id_data, path) is not None:
        raise Refused(f"Shape key '{key.name}' is animated: take the animation off before a bone drives it")
    key.driver_remove("value")
    driver = key.driver_add("value").driver
    driver.type = "SCRIPTED"
    for name, (channel, _) in channels.items():
        variable = driver.variables.new()
        variable.name, variable.type = name, "TRANSFORMS"
        target = variable.targets[0]
        target.id, target.bone_target = rig, bone.name
        target.transform_type, target.rotation_mode = channel, "SWING_TWIST_Y"
        target.transform_space = "LOCAL_SPACE"
    driver.expression = " + ".join(f"{value / squared:.6g} * {name}" for name, (_, value) in channels.items())


def _local(rig, bone):
    """The rotation of a bone against its rest, in its own axes: what LOCAL_SPACE tells."""
    found = rig.convert_space(pose_bone=bone, matrix=bone.matrix, from_space="POSE", to_space="LOCAL")
    quaternion = found.to_quaternion()
    return Quaternion([-part for part in quaternion]) if quaternion.w < 0 else quaternion
