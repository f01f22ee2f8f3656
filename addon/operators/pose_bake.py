"""An animated pose as shape keys, one a frame, or as a point cache."""

import bpy
import numpy as np
from bpy.props import StringProperty

from .. import live
from ..bridge import checks, meshes, playback, poses, shape_keys, standing
from ..core import cache, space
from ..core.refused import Refused, first
from ..core.work import Work
from ..properties.options import iterations_property
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
            self._check_names(obj)
        self._mesh = meshes.Snapshot.of(obj, poses.linear_part(obj))
        with live.paused():
            motions = playback.sample(scene, obj, frames)
        skin = standing.of(obj, poses.preview(obj))
        linear, options = self._mesh.linear, {"max_iterations": self.max_iterations, "warm_start": False}

        def steps():
            shapes, restless = [], []
            try:
                for frame, motion in zip(frames, motions, strict=True):
                    vertices, report = yield from bound.steps(motion, **options)
                    options.pop("warm_start", None)  # each frame but the first goes on from the last
                    shape = space.back(linear, vertices)
                    shapes.append((shape if skin is None else skin.key(shape)).astype(np.float32))
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
        settings = obj.lissom_pose
        if self.output == "CACHE":
            path, absolute = self._path
            cache.write(absolute, shapes, frames[0], self.step)
            unbind(obj)
            settings.baked_cache = playback.play_cache(obj, self.name, path, frames[0], self.step)
        else:
            self._check_names(obj)
            earlier = [baked.name for baked in settings.baked]
            for name in earlier:
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
            unbind(obj)
        context.scene.frame_set(context.scene.frame_current, subframe=context.scene.frame_subframe)
        if restless:
            self.report(
                {"WARNING"},
                f"Not converged at {len(restless)} of {len(frames)} frames, the first is {restless[0]}: "
                "raise Iterations",
            )
        self.report({"INFO"}, self.summary(f"'{obj.name}'", frames))


classes = (LISSOM_OT_pose_bake,)
