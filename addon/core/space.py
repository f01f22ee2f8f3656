"""The space that meshes are solved in: the object's own, with rotation and scale of the object applied.

A mesh under a non-uniform or mirrored object scale looks other than its coordinates say, and "as rigid as
possible" must mean what the eye sees. The location is left out: it would only cost digits.
"""

import numpy as np

from .refused import Refused

# Blender stores matrices in single precision; below this ratio of the smallest to the largest singular
# value the way back would amplify rounding beyond any use.
SINGULAR = 1e-6

# What single precision leaves of a motion that is none, as a part of the lengths that it came from.
STILL = 1e-6

# Between an axis and the normal of the plane across it the cosine is nearer to 1 where nothing is sheared.
SHEARED = 1e-5

# Vertices lie in a plane, or in a line, where they spread no further out of it, as a part of their size.
FLAT = 1e-4

LARGEST = float(np.finfo(np.float32).max)


def linear_part(matrix_world, name):
    """The 3x3 linear part of a 4x4 object matrix; refused where it cannot be inverted (row 36)."""
    matrix = np.array(matrix_world, dtype=np.float64)
    if not np.isfinite(matrix).all():
        raise Refused(
            f"The location, rotation or scale of object '{name}' is not a finite number: set it anew, then "
            "run again"
        )
    linear = matrix[:3, :3]
    values = np.linalg.svd(linear, compute_uv=False)
    if values[2] <= SINGULAR * values[0]:
        raise Refused(
            f"The scale of object '{name}' is zero along an axis: set it to another value, then run again"
        )
    return linear


def mirror_normal(linear, axis, name):
    """(3,) as a tuple: the normal in solve space of the plane across an axis of the object.

    Refused where the object is sheared, so that its mirror image is none in the scene.
    """
    along = linear[:, axis] / np.linalg.norm(linear[:, axis])
    normal = np.linalg.inv(linear)[axis]
    normal = normal / np.abs(normal).max()
    if abs(along @ normal) < (1 - SHEARED) * np.linalg.norm(normal):
        raise Refused(
            f"'{name}' is sheared by its parents, so that it has no mirror: apply its scale, then run again"
        )
    return tuple(float(number) for number in normal)


def into(linear, positions):
    """Object coordinates (..., 3) to solve space."""
    return positions if _is_applied(linear) else positions @ linear.T


def outward(linear, triangles):
    """(m, 3) triangles that face outward in solve space too: a mirrored surface is turned inside out."""
    return triangles[:, ::-1] if np.linalg.det(linear) < 0 else triangles


def back(linear, positions):
    """Solve space (..., 3) to object coordinates; refused where Blender cannot hold them (row 4)."""
    positions = positions if _is_applied(linear) else positions @ np.linalg.inv(linear).T
    if positions.size and max(positions.max(), -positions.min()) > LARGEST:
        raise Refused(
            f"The result reaches beyond the largest coordinate that Blender can hold, {LARGEST:.1e}: "
            "scale the mesh down first"
        )
    return positions


def _is_applied(linear):
    # So it is with most objects, and live updates go both ways each time.
    return np.array_equal(linear, np.eye(3))


def part_motion(first_rest, rest, first_now, now):
    """How a part has moved relative to the first object, from their matrices (4, 4) at rest and now.

    A (4, 4) of solve space, whose origin is the first object's location; None where the part has not moved,
    but for rounding.
    """
    lift = np.eye(4)
    lift[:3, :3] = first_rest[:3, :3]
    stay = np.linalg.inv(rest) @ first_rest @ np.linalg.inv(lift)
    motion = lift @ np.linalg.inv(first_now) @ now @ stay
    reach = max(np.abs(matrix[:3]).max() for matrix in (first_rest, rest, first_now, now))
    off = np.abs(motion - np.eye(4))
    return None if off[:3, :3].max() <= STILL and off[:3, 3].max() <= STILL * reach else motion


def applied(world_before, world_now, before, now):
    """The change of an object's coordinates (4, 4) where its transforms were applied or its origin was set.

    ``before`` and ``now`` are (k, 3) vertices in these coordinates, the worlds the object's matrices (4, 4).
    None where the vertices did not move, or not so that all of them stay where they are in the scene.
    """
    if np.array_equal(np.float32(before), np.float32(now)) or not abs(np.linalg.det(world_now)) > 0:
        return None
    change = np.linalg.inv(world_now) @ world_before
    change[3] = 0.0, 0.0, 0.0, 1.0
    moved = before @ change[:3, :3].T + change[:3, 3]
    reach = (
        np.abs(change[:3, :3]).sum() * np.abs(before).max() + np.abs(change[:3, 3]).max() + np.abs(now).max()
    )
    if np.allclose(change, np.eye(4), atol=STILL) or not np.abs(moved - now).max() <= 10 * STILL * reach:
        return None
    return change


def linear_change(before, now):
    """(3, 3): how a mesh has turned and scaled in its coordinates, by some vertices before and now, (k, 3).

    As *Apply Scale* or *Apply Rotation* changes them; the identity where these moved in any other way, as
    by sculpting. Out of the plane of vertices in a plane, lengths change as they do within it.
    """
    if len(before) != len(now) or not len(now) or np.array_equal(before, now):
        return np.eye(3)
    old, new = before - before.mean(axis=0), now - now.mean(axis=0)
    _, values, axes = np.linalg.svd(old, full_matrices=False)
    if values[1] <= FLAT * values[0]:  # in a line: nothing is known of the turn about it
        return np.eye(3)
    if values[2] <= FLAT * values[0]:
        images = axes[:2] @ np.linalg.lstsq(old, new, rcond=FLAT)[0]
        across = np.cross(*images)
        long = np.sqrt(np.linalg.norm(across))
        images = np.array([*images, across / long if long else across])
        axes = np.array([*axes[:2], np.cross(*axes[:2])])
        change = images.T @ axes
    else:
        change = np.linalg.lstsq(old, new, rcond=None)[0].T
    reach = np.abs(change).sum() * np.abs(before).max() + np.abs(now).max()
    affine = np.abs(old @ change.T - new).max() <= STILL * reach
    still = np.abs(change - np.eye(3)).max() <= 10 * STILL
    return change if affine and not still else np.eye(3)


def handle_transforms(linear, rest, posed):
    """Rest -> posed in solve space, (h, 4, 4), from handle matrices in object coordinates (h, 4, 4) each.

    T = (L P) (L R)^-1, with L the linear part, R the rest and P the posed matrix of a handle.
    """
    lift = np.eye(4)
    lift[:3, :3] = linear
    transforms = lift @ posed @ np.linalg.inv(lift @ rest)
    transforms[:, 3] = 0.0, 0.0, 0.0, 1.0  # Blender's matrices are not affine to the last bit
    return transforms
