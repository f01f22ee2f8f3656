"""Shape keys: absolute positions; Blender adds their difference to the relative key, times the value."""

from dataclasses import dataclass

import bpy
import numpy as np

from ..core.refused import Refused
from . import animation, groups
from .meshes import positions


@dataclass
class Settings:
    """Everything of a shape key but its shape."""

    value: float = 0.0
    slider_min: float = 0.0
    slider_max: float = 1.0
    mute: bool = False
    vertex_group: str = ""

    @classmethod
    def of(cls, key):
        """As ``key`` has them."""
        return cls(key.value, key.slider_min, key.slider_max, key.mute, key.vertex_group)


def key_names(obj):
    """Names of all shape keys but the reference key and the one that shows a live pose."""
    keys = obj.data.shape_keys
    if keys is None:
        return []
    left_out = previews(obj.data)
    return [key.name for key in keys.key_blocks if key != keys.reference_key and key.name not in left_out]


def previews(mesh):
    """Names of the shape keys that show the live pose of a bound object with this mesh."""
    bound = [obj for obj in bpy.data.objects if obj.lissom_pose.bound]
    rows = [row for obj in bound for row in obj.lissom_pose.company if row.object is not None]
    others = {row.preview for row in rows if row.object.data == mesh}
    return {obj.lissom_pose.preview for obj in bound if obj.data == mesh} | others


def preview(obj, name):
    """The shape key of that name, which shows a live pose; Refused where it is gone."""
    keys = obj.data.shape_keys
    key = keys.key_blocks.get(name) if keys else None
    if key is None:
        raise Refused(
            f"Shape key '{name}' of '{obj.name}', which shows the live pose, was removed or renamed: press "
            "Unbind, then Bind"
        )
    return key


def refuse_preview(key):
    """Refused for a key that shows a live pose: it changes with every move of a handle."""
    if key.name in previews(key.id_data.user):
        raise Refused(
            f"Shape key '{key.name}' shows the live pose and goes with it: press Apply, "
            "then choose the key that it makes"
        )


def find(obj, name):
    """The shape key of that name; Refused where there is none."""
    keys = obj.data.shape_keys
    key = keys.key_blocks.get(name) if keys else None
    if key is None:
        raise Refused(f"'{obj.name}' has no shape key named '{name}'")
    return key


def shape(key):
    """(n, 3) float64 absolute positions."""
    return positions(key.points)


def probes(mesh, count):
    """(count, 3): some vertices of the Basis, by which one tells how the mesh's coordinates have changed."""
    points = mesh.shape_keys.reference_key.points if mesh.shape_keys else mesh.vertices
    places = np.linspace(0, len(points) - 1, count).astype(int).tolist() if len(points) else []
    return np.array([points[place].co for place in places], dtype=np.float64).reshape(-1, 3)


def seen(obj, key, over=None):
    """(n, 3): what is shown with this key of ``obj`` at 1, over the key ``over`` (the reference key) alone.

    Whatever its relative key (row 33), and where its vertex group lets it.
    """
    over, relative = over or key.id_data.reference_key, key.relative_key
    masked = key != over and key.vertex_group in obj.vertex_groups
    if not masked and over in (key, relative):
        return shape(key)
    mask = groups.weights(obj, key.vertex_group)[:, None] if masked else 1.0
    return shape(over) + mask * (shape(key) - shape(relative))


def ensure_basis(obj):
    """The reference key, made from the mesh where there are no shape keys yet."""
    if obj.data.shape_keys is None:
        obj.shape_key_add(name="Basis", from_mix=False)
    return obj.data.shape_keys.reference_key


def write(obj, name, vertices, settings=None, relative=None):
    """Writes absolute positions (n, 3) as the shape key ``name``, which is made where it is missing.

    ``settings`` None keeps those of a key that exists. ``relative`` is the relative key, by default the
    reference key.
    """
    basis = ensure_basis(obj)
    key = obj.data.shape_keys.key_blocks.get(name)
    if key is None:
        key = obj.shape_key_add(name=name, from_mix=False)
        settings = settings or Settings()
    key.relative_key = relative or basis
    if settings:
        apply(key, settings, obj)
    _shift_relatives(key, vertices - shape(key), {key.name})
    write_points(key, vertices)
    return key


def _shift_relatives(key, delta, seen):
    """Keys that count from this one go along with it, so that each keeps what it adds."""
    for other in key.id_data.key_blocks:
        if other.relative_key == key and other.name not in seen:
            seen.add(other.name)
            _shift_relatives(other, delta, seen)
            write_points(other, shape(other) + delta)


def apply(key, settings, obj):
    """Sets all settings: a new key's own defaults differ from version to version (value 1 from 5.0 on)."""
    # Each end of the range is clamped against the other: widen before narrowing, and the value last.
    key.slider_min, key.slider_max = -10.0, 10.0
    key.slider_max = settings.slider_max
    key.slider_min = settings.slider_min
    key.value = settings.value
    key.mute = settings.mute
    key.vertex_group = settings.vertex_group if settings.vertex_group in obj.vertex_groups else ""


def write_points(key, vertices):
    """Overwrites the positions of a key with (n, 3) values."""
    key.points.foreach_set("co", np.ascontiguousarray(vertices, dtype=np.float32).ravel())
    key.id_data.user.update()  # 4.2 does not see foreach_set by itself


def remove(obj, name):
    """Removes a key with what animates it; the choice in the list stays, or goes to the key before."""
    key = find(obj, name)
    place, chosen = key.id_data.key_blocks.find(name), obj.active_shape_key_index
    animation.remove(key.id_data, key.path_from_id("value"))
    obj.shape_key_remove(key)  # chooses the first of the list
    obj.active_shape_key_index = max(0, chosen - (place <= chosen))


def clear(obj):
    """Removes all keys of an object, and what holds them."""
    name = obj.data.shape_keys.name
    obj.shape_key_clear()
    left = bpy.data.shape_keys.get(name)
    if left is not None:  # 5.0 counts those of a copied mesh twice
        bpy.data.batch_remove([left])


def is_driven(key):
    """True where a driver or an animation sets the key's value."""
    keys, path = key.id_data, key.path_from_id("value")
    found = animation.driver(keys, path), animation.curve(keys, path)
    return any(one is not None for one in found) or animation.in_nla(keys, path)
