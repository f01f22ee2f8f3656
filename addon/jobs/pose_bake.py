"""An animated pose as shape keys, one a frame, or as a point cache; the mesh is released, and plays it."""

from dataclasses import dataclass

import numpy as np

from .. import session
from ..bridge import checks, company, meshes, playback, poses, shape_keys
from ..core import bake, cache
from ..core.refused import Refused, first
from ..core.work import Work
from . import bound
from .pose import PoseDone, SolveAsked, release


@dataclass(kw_only=True)
class BakeAsked(SolveAsked):
    """What an animated pose is baked to."""

    frames: list[int]  # in rising order
    step: int = 1  # between them
    name: str = "Pose"  # of the shape keys, before the frame, or of the modifier
    output: str = "KEYS"  # or "CACHE"
    filepath: str = ""  # of the cache


@dataclass(kw_only=True)
class BakeDone(PoseDone):
    """``keys``: their names, one a frame; ``restless``: frames at which the solve did not converge."""

    frames: list[int]
    keys: list[str]
    cache: str
    restless: list[int]


class BakePose:
    """The motion of the handles over a range of frames."""

    def __init__(self, context, asked):
        context.view_layer.update()
        obj = checks.mesh_object(asked.object, context)
        checks.require_writable(obj)
        pose = bound.current(obj)
        poses.preview(obj)
        self._asked, self._path, self._names = asked, ("", ""), []
        if asked.output == "CACHE":
            self._path = playback.cache_path(asked.filepath, obj)
            if company.rows(obj):
                raise Refused(
                    "A point cache holds one object: bake shape keys, or take the further objects off"
                )
        else:
            self._names = bake.key_names(asked.name, asked.frames)
            for other in [obj, *(row.object for row in company.rows(obj))]:
                self._check_names(other)
        self._mesh = meshes.Snapshot.of(obj, poses.linear_part(obj))
        with session.paused():
            motions = playback.sample(context.scene, obj, asked.frames)
        self.work = Work(self._steps(pose, motions), count=len(asked.frames), stage="frame")

    def _steps(self, pose, motions):
        options = {"max_iterations": self._asked.max_iterations, "warm_start": False}
        shapes, restless = [], []
        try:
            for frame, motion in zip(self._asked.frames, motions, strict=True):
                vertices, report = yield from pose.steps(motion, **options)
                options.pop("warm_start", None)  # each frame but the first goes on from the last
                shapes.append(vertices)
                if not report["converged"]:
                    restless.append(frame)
        finally:
            pose.forget()  # what is shown is the pose of now
        return shapes, restless

    def _check_names(self, obj):
        blocks = obj.data.shape_keys.key_blocks
        ours = {baked.name for baked in obj.lissom_pose.baked}
        taken = [name for name in self._names if name in blocks and name not in ours]
        if taken:
            raise Refused(f"Shape key {first(repr(name) for name in taken)} exists: choose another name")
        checks.require_unlocked([blocks[name] for name in ours if name in blocks])

    def write(self, context, result):
        """Writes the shapes of all frames; a BakeDone."""
        shapes, restless = result
        obj, asked = self._mesh.find(), self._asked
        checks.require_writable(obj)
        if asked.output == "CACHE":
            self._write_cache(obj, shapes)
            what = "a point cache"
        else:
            self._write_all(obj, shapes)
            what = f"{len(asked.frames)} shape keys"
        scene, frames = context.scene, asked.frames
        scene.frame_set(scene.frame_current, subframe=scene.frame_subframe)
        warnings = []
        if restless:
            warnings.append(
                f"Not converged at {len(restless)} of {len(frames)} frames, the first is {restless[0]}: "
                "raise Iterations"
            )
        return BakeDone(
            summary=f"'{obj.name}' plays frames {frames[0]} to {frames[-1]} from {what}",
            warnings=warnings,
            object=obj.name,
            frames=frames,
            keys=self._names,
            cache=self._path[0],
            restless=restless,
        )

    def _write_cache(self, obj, shapes):
        (path, absolute), asked = self._path, self._asked
        own = [bound.key_shape(obj, vertices).astype(np.float32) for vertices in shapes]
        cache.write(absolute, own, asked.frames[0], asked.step)
        release(obj)
        settings = obj.lissom_pose
        settings.baked_cache = playback.play_cache(obj, asked.name, path, asked.frames[0], asked.step)

    def _write_all(self, obj, shapes):
        played = zip(*(bound.key_shapes(obj, vertices) for vertices in shapes), strict=True)
        played = [(own[0][0], [shape.astype(np.float32) for _, _, shape in own]) for own in played]
        for other, _ in played:
            self._check_names(other)
        for other, own in played:
            self._write_keys(other, own)
        release(obj)

    def _write_keys(self, obj, shapes):
        settings = obj.lissom_pose
        for name in [baked.name for baked in settings.baked]:
            if name in obj.data.shape_keys.key_blocks:
                shape_keys.remove(obj, name)
        settings.baked.clear()
        cached = obj.modifiers.get(settings.baked_cache)
        if cached is not None:  # it would hide the keys
            obj.modifiers.remove(cached)
        settings.baked_cache = ""
        for name, shape in zip(self._names, shapes, strict=True):
            shape_keys.write(obj, name, shape, shape_keys.Settings())
            settings.baked.add().name = name
        playback.play_keys(obj, self._names, self._asked.frames)
