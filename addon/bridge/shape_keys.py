"""Shape keys: absolute positions; Blender adds their difference to the relative key, times the value."""

from dataclasses import dataclass

import numpy as np

from ..core.refused import Refused
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
    """Names of all shape keys but the reference key."""
    keys = obj.data.shape_keys
    return [key.name for key in keys.key_blocks if key != keys.reference_key] if keys else []


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
    write_points(key, vertices)
    return key


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
    """Removes a key with its driver; the reference key goes with the last other one."""
    key = find(obj, name)
    key.driver_remove("value")
    obj.shape_key_remove(key)


def is_driven(key):
    """True where a driver sets the key's value."""
    data = key.id_data.animation_data
    return data is not None and data.drivers.find(key.path_from_id("value")) is not None
