"""An animated pose as shape keys, one a frame, or as a point cache."""

import bpy
import numpy as np
from bpy.props import StringProperty

from .. import live
from ..bridge import checks, company, meshes, playback, poses, shape_keys
from ..core import cache
from ..core.refused import Refused, first
from ..core.work import Work
from ..properties.options import iterations_property
from ..translations import translated
from .baking import CACHE_FILE, BakeProperties
from .job import JobOperator, writable_mesh
from .pose_bind import unbind
from .pose_handles import OBJECT


class LISSOM_OT_pose_bake(BakeProperties, JobOperator, bpy.types.Operator):
    """Bake the motion of the handles over a range of frames, and unbind the mesh, which then plays it"""

    bl_idname = "lissom.pose_bake"
    bl_label = "Bake Animation"
    bl_options = {"REGISTER", "UNDO"}

    object: StringProperty(**OBJECT)
    filepath: StringProperty(**CACHE_FILE)
    max_iterations: iterations_property()

    @classmethod
    def poll(cls, context):
        return writable_mesh(cls, context, bound=True)

    def begin(self, context):
        context.view_layer.update()
        scene, obj = context.scene, checks.mesh_object(self.object, context)
        checks.require_writable(obj)
        bound = poses.current(obj)
        poses.preview(obj)
        frames = self._frames = self.frames(scene)
        if self.output == "CACHE":
            self._path = playback.cache_path(self.filepath, obj)
        else:
            self._names = self.key_names(frames)
            for other in [obj, *(row.object for row in company.rows(obj))]:
                self._check_names(other)
        if self.output == "CACHE" and len(obj.lissom_pose.company):
            raise Refused("A point cache holds one object: bake shape keys, or take the further objects off")
        self._mesh = meshes.Snapshot.of(obj, poses.linear_part(obj))
        with live.paused():
            motions = playback.sample(scene, obj, frames)
        options = {"max_iterations": self.max_iterations, "warm_start": False}

        def steps():
            shapes, restless = [], []
            try:
                for frame, motion in zip(frames, motions, strict=True):
                    vertices, report = yield from bound.steps(motion, **options)
                    options.pop("warm_start", None)  # each frame but the first goes on from the last
                    shapes.append(vertices)
                    if not report["converged"]:
                        restless.append(frame)
            finally:
                bound.forget()  # what is shown is the pose of now
            return shapes, restless

        return Work(steps(), count=len(frames), stage="frame")

    def _blocks(self, obj):
        return obj.data.shape_keys.key_blocks

    def _check_names(self, obj):
        blocks = self._blocks(obj)
        ours = {baked.name for baked in obj.lissom_pose.baked}
        taken = [name for name in self._names if name in blocks and name not in ours]
        if taken:
            raise Refused(f"Shape key {first(repr(name) for name in taken)} exists: choose another name")
        checks.require_unlocked([blocks[name] for name in ours if name in blocks])

    def finish(self, context, result):
        shapes, restless = result
        obj, frames = self._mesh.find(), self._frames
        checks.require_writable(obj)
        if self.output == "CACHE":
            path, absolute = self._path
            own = [poses.key_shape(obj, vertices).astype(np.float32) for vertices in shapes]
            cache.write(absolute, own, frames[0], self.step)
            unbind(obj)
            baked = playback.play_cache(obj, self.name, path, frames[0], self.step)
            obj.lissom_pose.baked_cache = baked
        else:
            played = zip(*(poses.key_shapes(obj, vertices) for vertices in shapes), strict=True)
            played = [(own[0][0], [shape.astype(np.float32) for _, _, shape in own]) for own in played]
            for other, _ in played:
                self._check_names(other)
            for other, own in played:
                self._write_keys(other, own, frames)
            unbind(obj)
        context.scene.frame_set(context.scene.frame_current, subframe=context.scene.frame_subframe)
        if restless:
            self.report(
                {"WARNING"},
                f"Not converged at {len(restless)} of {len(frames)} frames, the first is {restless[0]}: "
                "raise Iterations",
            )
        self.report({"INFO"}, translated(self.summary(f"'{obj.name}'", frames)))

    def _write_keys(self, obj, shapes, frames):
        settings = obj.lissom_pose
        for name in [baked.name for baked in settings.baked]:
            if name in self._blocks(obj):
                shape_keys.remove(obj, name)
        settings.baked.clear()
        cached = obj.modifiers.get(settings.baked_cache)
        if cached is not None:  # it would hide the keys
            obj.modifiers.remove(cached)
        settings.baked_cache = ""
        for name, shape in zip(self._names, shapes, strict=True):
            shape_keys.write(obj, name, shape, shape_keys.Settings())
            settings.baked.add().name = name
        playback.play_keys(obj, self._names, frames)


classes = (LISSOM_OT_pose_bake,)
