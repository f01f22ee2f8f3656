"""The native pose of a bound mesh object, which the session keeps, and the keys that show it."""

import lissom
import numpy as np

from .. import session
from ..bridge import checks, company, groups, meshes, mirrors, poses, shape_keys, standing
from ..core import pose as core_pose
from ..core import space
from ..core.pose import check_groups
from ..core.refused import Refused
from ..core.work import Work


def bind_work(obj, linear, asked, skin=None):
    """Work whose result is a BoundPose of the object as its Skin shows it, by its settings' vertex groups."""
    settings = obj.lissom_pose
    names = [handle.name for handle in settings.handles]
    found = groups.weighted_members(obj, [*names, settings.roi])
    on_others, others = company.members(obj, [*names, settings.roi])
    for name, (indices, weights) in on_others.items():
        if indices and name in found:
            found[name] = tuple(map(np.concatenate, ([found[name][0], *indices], [found[name][1], *weights])))
    members = {name: indices for name, (indices, _) in found.items()}
    check_groups(members, names, settings.roi)
    region = members.get(settings.roi)
    return core_pose.bind_work(
        space.into(linear, _stood(obj, skin)),
        space.outward(linear, meshes.triangles(obj.data)),
        meshes.corners(obj.data),
        [members[name] for name in names],
        [found[name][1] for name in names],
        None if region is None else np.union1d(region, others),
        asked,
        mirrors.of(obj, linear, asked.symmetry),
        company.of(obj, linear, skin_of_row),
        poses.is_adrift(settings),
    )


def _stood(obj, skin):
    return meshes.rest_positions(obj.data) if skin is None else skin.shown


def current(obj):
    """The bound pose of the object: the one in memory while it holds, else made anew.

    That happens after loading a file, or where rest shape, mirrors, method or options were changed. New
    faces need a new Bind (row 26).
    """
    settings = obj.lissom_pose
    if not settings.bound:
        raise Refused(f"'{obj.name}' is not bound: press Bind first")
    reason = poses.foreign_handles(obj)
    if reason:
        raise Refused(reason)
    if obj.session_uid in session.rebinding:
        raise Refused(f"'{obj.name}' is still being bound anew: wait a moment")
    linear = poses.linear_part(obj)
    if settings.stood and has_moved(obj):
        raise Refused(
            f"What moves '{obj.name}' stands elsewhere than at Bind: put it back, or press Unbind, then Bind"
        )
    known = session.poses.get(obj.session_uid)
    if known is not None:
        rest = space.into(linear, _stood(obj, skin_of(obj)))
        wanted = poses.asked(settings)
        mirrored = mirrors.of(obj, linear, wanted.symmetry)
        others = company.of(obj, linear, skin_of_row)
        corners = meshes.corners(obj.data)
        if known.fits(rest, corners, len(settings.handles), wanted, mirrored, others):
            return known
    made = session.poses[obj.session_uid] = bind_again(obj).wait()
    made.forget()
    return made


def bind_again(obj):
    """Work whose result is the BoundPose of an object that is bound, by its settings of now (row 26)."""
    if meshes.signature(obj.data) != obj.lissom_pose.topology:
        raise Refused(f"The mesh of '{obj.name}' was remodelled since Bind: press Unbind, then Bind")
    skin = skin_of(obj)
    return bind_work(obj, poses.linear_part(obj), poses.asked(obj.lissom_pose), skin)


def key_shape(obj, vertices):
    """(n, 3): the shape key that shows (n, 3) solved positions, through the Skin where the object has one."""
    shape = space.back(poses.linear_part(obj), vertices[: len(obj.data.vertices)])
    skin = skin_of(obj)
    return shape if skin is None else skin.key(shape)


def key_shapes(obj, vertices):
    """[(object, its key that shows the pose, (n, 3) shape)] of a solve: the bound object and its company."""
    others = company.shapes(obj, poses.linear_part(obj), vertices, skin_of_row)
    return [(obj, poses.preview(obj), key_shape(obj, vertices)), *others]


def show(obj, vertices):
    """Writes solved positions to the keys that show the pose."""
    for _, key, shape in key_shapes(obj, vertices):
        shape_keys.write_points(key, shape)


def following(obj, seconds=None):
    """Work that solves a bound object if its handles moved, within about ``seconds``, and shows it.

    Its result is whether it wants more.

    What was undone, reset, unbound, removed or put into another mode meanwhile is not touched.
    """
    return Work(_follow(obj, obj.session_uid, seconds))


def follow(obj, seconds=None):
    """The same at once: whether it wants more."""
    return following(obj, seconds).wait()


def _follow(obj, uid, seconds):
    settings = obj.lissom_pose
    if not (settings.bound and settings.live) or obj.mode != "OBJECT":
        return False
    try:
        pose = current(obj)
        motion = poses.motion(obj)
        if not pose.is_due(motion):
            return False
        poses.preview(obj)
        options = {"max_iterations": pose.iterations_within(seconds, motion)} if seconds else {}
        breaks = pose.breaks
        vertices, report = yield from pose.steps(motion, **options)
        obj = checks.by_uid(uid)
        same = pose.breaks == breaks and session.poses.get(uid) is pose
        if obj is None or obj.mode != "OBJECT" or not same:
            pose.forget()
            return obj is not None
        show(obj, vertices)
    except (Refused, lissom.Error) as error:
        session.status[uid] = ("ERROR", str(error))
        return False
    except Exception as error:  # a bug of ours: shown and printed once, not at every move of the mouse
        obj.lissom_pose.live = False
        session.status[uid] = ("ERROR", f"Live is off after an error: {error}")
        raise
    solved = ("CHECKMARK", f"Solved in {1e3 * report['seconds']:.1f} ms")
    session.status[uid] = ("ERROR", pose.doubts[0]) if pose.doubts else solved
    return not pose.converged


def reset(obj):
    """Handles and preview at rest."""
    poses.place_at_rest(obj)
    shape_keys.write_points(poses.preview(obj), meshes.rest_positions(obj.data))
    company.put_to_rest(obj)
    if obj.session_uid in session.poses:
        session.poses[obj.session_uid].put_to_rest()


def skin_of(obj):
    """The Skin that a bound object was bound with, or None; read anew after a file was loaded, or the rest
    shape was changed."""
    return _skin(obj, obj.lissom_pose, poses.preview)


def skin_of_row(row):
    """The same of a further object, which the row of a bound one names."""
    return _skin(row.object, row, lambda obj: company.preview(row))


def _skin(obj, settings, preview_of):
    if not settings.stood:
        return None
    known = session.skins.get(obj.session_uid)
    if known is None or not np.array_equal(known.rest, meshes.rest_positions(obj.data)):
        known = session.skins[obj.session_uid] = standing.read(obj, preview_of(obj))
    return known


def has_moved(obj):
    """Whether a bound object's bones or the objects of its modifiers stand elsewhere than at Bind."""
    known = session.stances.get(obj.session_uid)
    if known is None:
        session.stances[obj.session_uid] = standing.stance(obj)
        return False
    now = standing.stance(obj)
    return len(now) != len(known) or not np.allclose(now, known, atol=1e-4)


def stop_binding(obj):
    """Stops the work that binds an object anew, as its options were changed."""
    work = session.rebinding.pop(obj.session_uid, None)
    if work is not None:
        work.cancel()


def forget(obj):
    """Lets go of all that is kept of an object that is bound no more."""
    stop_binding(obj)
    for known in (session.poses, session.skins, session.stances):
        known.pop(obj.session_uid, None)
    for row in obj.lissom_pose.company:
        if row.object is not None:
            session.skins.pop(row.object.session_uid, None)
    session.status.pop(obj.session_uid, None)
