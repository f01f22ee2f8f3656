"""How a mesh stands: what armature, other keys and modifiers make of its rest shape, as core.skin.Skin."""

import contextlib

import bpy
import numpy as np

from ..core import space
from ..core.skin import Skin
from . import checks, meshes, shape_keys
from .generative import evaluated, same_vertices, turn

PROBE = "Lissom Probe"
SAME = 1e-6  # of the extent: modifiers that move vertices less than this move none


DEFORMING = {
    "ARMATURE", "CAST", "CLOTH", "CORRECTIVE_SMOOTH", "CURVE", "DISPLACE", "HOOK", "LAPLACIANDEFORM",
    "LAPLACIANSMOOTH", "LATTICE", "MESH_CACHE", "MESH_DEFORM", "SHRINKWRAP", "SIMPLE_DEFORM", "SMOOTH",
    "SOFT_BODY", "SURFACE_DEFORM", "WARP", "WAVE",
}  # fmt: skip


def keys_on(obj):
    """Names of the shape keys that add to what is seen of an object, but those that Bake made."""
    keys, baked = obj.data.shape_keys, obj.lissom_pose.baked.keys()
    return [
        key.name
        for key in (keys.key_blocks if keys else [])
        if key != keys.reference_key and not key.mute and key.value and key.name not in baked
    ]


def deforming(obj):
    """The modifiers of an object that move vertices now and make none."""
    own = obj.lissom_pose.baked_cache
    return [modifier for modifier in obj.modifiers if modifier.name != own and _deforms(modifier)]


def _deforms(modifier):
    kind = modifier.type
    if not modifier.show_viewport or kind not in DEFORMING:
        return False
    if kind != "ARMATURE":
        return True
    rig = modifier.object
    if rig is None or rig.data.pose_position == "REST":
        return False
    turned = (np.array(bone.matrix_channel) for bone in rig.pose.bones)  # constraints included
    return any(not np.allclose(matrix, np.eye(4), atol=space.STILL) for matrix in turned)


def read(obj, preview=None):
    """The Skin of a mesh object in its own coordinates, or None where its rest shape is what one sees.

    ``preview`` is the key that shows a live pose, which is left out; without one a key is made for the while.
    """
    if not (preview or deforming(obj) or keys_on(obj)) or not checks.is_shown(obj):
        return None
    rest = meshes.rest_positions(obj.data)
    made = obj.data.shape_keys is None
    chosen = obj.active_shape_key_index
    if preview is None:
        shape_keys.ensure_basis(obj)
        key = shape_keys.write(obj, PROBE, rest, shape_keys.Settings(value=1.0))
        before = None
    else:
        key, before = preview, shape_keys.shape(preview)
    pinned, obj.show_only_shape_key = obj.show_only_shape_key, False

    def look(shape):
        shape_keys.write_points(key, shape)
        bpy.context.view_layer.update()
        return meshes.positions(evaluated(obj).data.vertices)

    extent = float(np.linalg.norm(np.ptp(rest, axis=0))) if len(rest) else 0.0
    try:
        with same_vertices([obj]), _without_cache(obj):
            skin = Skin.of(rest, look, extent or 1.0)
    finally:
        if before is None:
            shape_keys.remove(obj, key.name)
            if made:
                obj.shape_key_clear()
            else:
                obj.active_shape_key_index = chosen
        else:
            shape_keys.write_points(key, before)
        obj.show_only_shape_key = pinned
        bpy.context.view_layer.update()
    hopeless = 2 * len(skin.flat) > len(rest)  # as what plays a cache: it does not heed keys
    return None if hopeless or skin.is_trivial(SAME * extent) else skin


@contextlib.contextmanager
def _without_cache(obj):
    """What Bake made of the object would hide a live pose."""
    caches = [m for m in obj.modifiers if m.name == obj.lissom_pose.baked_cache and m.show_viewport]
    try:
        turn(caches, "show_viewport", False)
        yield
    finally:
        turn(caches, "show_viewport", True)


def shown(obj):
    """(n, 3) in an object's own coordinates: where one sees it, or where it rests if Bind is to pose that."""
    rest = meshes.rest_positions(obj.data)
    if obj.mode == "EDIT" or not (deforming(obj) or keys_on(obj)):
        return rest
    if not (obj.lissom_pose.stands and checks.is_shown(obj)):
        return rest
    with same_vertices([obj]):
        return meshes.positions(evaluated(obj).data.vertices)


def stance(obj):
    """Numbers that are others once what deforms an object has moved: bones, and the objects of modifiers."""
    found = []
    for modifier in obj.modifiers:
        other = getattr(modifier, "object", None)
        if not modifier.show_viewport or other is None:
            continue
        found.append(np.array(obj.matrix_world.inverted_safe() @ other.matrix_world).ravel())
        if other.type == "ARMATURE" and other.data.pose_position == "POSE":
            found += [np.array(bone.matrix_channel).ravel() for bone in other.pose.bones]
    return np.concatenate(found) if found else np.zeros(0)
