"""Pose: a mesh is bound to its handles, solved, kept as a shape key, and released."""

from dataclasses import dataclass

from .. import session
from ..bridge import baked, checks, company, empties, meshes, poses, shape_keys, standing
from ..core import names, pose_options, space
from ..core.options import default
from ..core.refused import Refused
from . import Asked, Done, applied, bound

ITERATIONS = default("pose.solve", "max_iterations")


@dataclass(kw_only=True)
class BindAsked(Asked):
    """What Bind is made of: the object by name, "" for the active one, with method and options."""

    object: str = ""
    pose: pose_options.Asked
    stands: bool = True  # as armature, other keys and modifiers show it
    company: tuple[str, ...] = ()  # names of further objects; none: those that are listed


@dataclass(kw_only=True)
class SolveAsked(Asked):
    """What a solve is made of."""

    object: str = ""
    max_iterations: int = ITERATIONS


@dataclass(kw_only=True)
class ApplyAsked(SolveAsked):
    """What a pose is kept as."""

    name: str = "Pose"
    exists: str = "RENAME"
    value: float = 1.0
    reset: bool = True


@dataclass(kw_only=True)
class PoseDone(Done):
    """``object``: the name of the mesh object."""

    object: str


@dataclass(kw_only=True)
class ApplyDone(PoseDone):
    """``written``: the name of the key on each object that has got it."""

    written: dict[str, str]


def bind_asked(obj):
    """What the panel of an object asks of Bind."""
    settings = obj.lissom_pose
    return BindAsked(object=obj.name, pose=poses.asked(settings), stands=settings.stands)


class Bind:
    """The mesh follows its handles from here on, in a shape key of its own."""

    def __init__(self, context, asked):
        context.view_layer.update()
        obj = checks.mesh_object(asked.object, context)
        checks.require_writable(obj)
        settings = obj.lissom_pose
        if settings.bound:
            raise Refused(f"'{obj.name}' is bound already: press Unbind first")
        linear = space.linear_part(obj.matrix_world, obj.name)
        self._rests = {}  # by the handle's name
        for handle in poses.alive_handles(obj):
            space.linear_part(handle.empty.matrix_world, handle.empty.name)
            self._rests[handle.name] = (
                empties.matrix_in(obj, handle.empty).ravel(),
                *empties.channels(handle.empty),
            )
        if asked.company:
            others = [checks.mesh_object(name, context) for name in asked.company]
            settings.company.clear()
            for other in others:
                company.add(obj, other)
        self._stands = asked.stands
        with session.paused():
            settings.stands = asked.stands
            self._skin = standing.read(obj) if asked.stands else None
            session.skins.update(company.begin(obj))
        self._mesh = meshes.Snapshot.of(obj, linear)
        self.work = bound.bind_work(obj, linear, asked.pose, self._skin)

    def write(self, context, pose):
        """Writes a core.pose.BoundPose; a PoseDone."""
        obj = self._mesh.find()
        checks.require_writable(obj)
        settings = obj.lissom_pose
        if settings.handles.keys() != list(self._rests):
            raise Refused(
                f"The handles of '{obj.name}' were changed meanwhile: nothing was written, run again"
            )
        settings.stands, settings.stood = self._stands, self._skin is not None
        warnings = [*poses.left_out(obj), *self._flat(obj), *pose.warnings, checks.shared_data(obj)]
        warnings = list(filter(None, warnings))
        settings.made_basis = obj.data.shape_keys is None
        company.finish(obj)
        basis = shape_keys.ensure_basis(obj)
        settings.preview = names.unused(company.PREVIEW, obj.data.shape_keys.key_blocks.keys())
        shape_keys.write(obj, settings.preview, shape_keys.shape(basis), shape_keys.Settings(value=1.0))
        for handle in settings.handles:
            handle.rest, handle.rotation_mode, handle.rotation = self._rests[handle.name]
        settings.topology = self._mesh.topology
        settings.linear = self._mesh.linear.ravel()
        settings.warnings = "\n".join(warnings)
        poses.keep(settings, pose.asked)
        baked.mute(obj, True)
        applied.note(obj)
        settings.bound = True
        session.poses[obj.session_uid] = pose
        session.skins.pop(obj.session_uid, None)
        if self._skin is not None:
            session.skins[obj.session_uid] = self._skin
            session.stances[obj.session_uid] = standing.stance(obj)
        told = "Bound: move an Empty"
        session.status[obj.session_uid] = ("CHECKMARK", told)
        return PoseDone(summary=told, warnings=warnings, object=obj.name)

    def _flat(self, obj):
        """Warns of vertices that the modifiers have collapsed, and selects them."""
        flat = [] if self._skin is None else self._skin.flat
        if not len(flat):
            return []
        meshes.select_vertices(obj, set(flat.tolist()))
        return [f"No key can move {len(flat)} vertices, which the modifiers collapse: they are selected"]


class Solve:
    """The mesh as its handles have it now, to the end of the iteration."""

    def __init__(self, context, asked):
        context.view_layer.update()
        obj = checks.mesh_object(asked.object, context)
        checks.require_writable(obj)
        self._pose = bound.current(obj)
        poses.preview(obj)
        self._mesh = meshes.Snapshot.of(obj, poses.linear_part(obj))
        self.work = self._pose.work(poses.motion(obj), max_iterations=asked.max_iterations)

    def write(self, context, result):
        """Shows what lissom.Pose.solve has found; a PoseDone."""
        vertices, report = result
        obj = self._mesh.find()
        bound.show(obj, vertices)
        rest = [*self._pose.doubts, *self._unrest(report)]
        solved = ("CHECKMARK", "Solved to the end")
        session.status[obj.session_uid] = ("ERROR", rest[0]) if rest else solved
        warnings = [*self._pose.warnings, *rest]
        return PoseDone(summary=f"'{obj.name}' is solved", warnings=warnings, object=obj.name)

    def _unrest(self, report):
        if report["converged"]:
            return []
        return [f"Not converged after {report['iterations']} iterations: raise Iterations"]


class Apply(Solve):
    """The pose as a shape key, of the mesh and of what goes along."""

    def __init__(self, context, asked):
        super().__init__(context, asked)
        obj, self._asked = self._mesh.find(), asked
        if not asked.name:
            raise Refused("Give the shape key a name first")
        blocks = obj.data.shape_keys.key_blocks
        self._name = names.resolve(asked.name, blocks.keys(), asked.exists)
        if self._name is None:
            raise Refused(f"Shape key '{asked.name}' exists, and If Exists is Skip: choose another name")
        key = blocks.get(self._name)
        if key is not None:
            if key in (poses.preview(obj), obj.data.shape_keys.reference_key):
                raise Refused(f"'{self._name}' is the shape key that the pose builds on: choose another name")
            checks.require_unlocked([key])

    def write(self, context, result):
        """Writes what lissom.Pose.solve has found; an ApplyDone."""
        vertices, report = result
        obj, asked, written = self._mesh.find(), self._asked, {}
        for other, preview, shape in bound.key_shapes(obj, vertices):
            blocks = other.data.shape_keys.key_blocks
            name = self._name if other == obj else names.resolve(self._name, blocks.keys(), asked.exists)
            key = name and blocks.get(name)
            if name and key not in (preview, other.data.shape_keys.reference_key):
                shape_keys.write(other, name, shape, shape_keys.Settings(value=asked.value))
                written[other.name] = name
        obj.lissom_pose.applied = self._name
        if asked.reset:
            bound.reset(obj)
        else:
            bound.show(obj, vertices)
        return ApplyDone(
            summary=f"Shape key '{self._name}' holds the pose",
            warnings=[*self._pose.warnings, *self._unrest(report)],
            object=obj.name,
            written=written,
        )


def reset(context, name=""):
    """Puts the handles of an object back where they were at Bind, and the mesh with them."""
    obj = checks.mesh_object(name, context)
    checks.require_writable(obj)
    bound.current(obj)
    bound.reset(obj)


def unbind(context, name=""):
    """Releases an object: the live pose is dropped, applied ones stay."""
    obj = checks.mesh_object(name, context)
    checks.require_writable(obj)
    if not obj.lissom_pose.bound:
        raise Refused(f"'{obj.name}' is not bound")
    release(obj)


def release(obj):
    """Drops the live pose of a bound mesh object."""
    settings = obj.lissom_pose
    poses.place_at_rest(obj)
    poses.drop_foreign_handles(obj)
    settings.bound = False
    poses.remove_preview(obj)
    for name in ("preview", "applied", "warnings"):
        settings.property_unset(name)
    baked.mute(obj, False)
    bound.forget(obj)
