"""Transfer of what the source looks like: of a pose as a shape key, of a range of frames as animation."""

import contextlib
import os

import bpy
import numpy as np
from bpy.props import StringProperty

from .. import live
from ..bridge import checks, evaluated, playback, shape_keys
from ..core import cache
from ..core.refused import Refused, first
from ..core.transfer import Keys, animation_steps, transfer_work
from ..core.work import Work
from ..properties.transfer import exists_property
from .baking import CACHE_FILE, BakeProperties
from .job import JobOperator
from .transfer_fit import Request, TransferProperties, ready, where
from .transfer_keys import destinations, without_empty

BLOCK = 32  # frames that are in memory at a time


def _request(operator, context):
    """The Request of meshes at rest, on objects where armatures at rest leave them; targets are writable."""
    with live.paused(), evaluated.at_rest():
        request = Request(operator, context)
    for target in request.target.objects():
        checks.require_writable(target)
    return request


class LISSOM_OT_transfer_pose(TransferProperties, JobOperator, bpy.types.Operator):
    """Carry over what the source looks like now, by armature, modifiers and shape keys, as one shape key"""

    bl_idname = "lissom.transfer_pose"
    bl_label = "Transfer Pose"
    bl_options = {"REGISTER", "UNDO"}

    name: StringProperty(name="Name", description="Name of the shape key", default="Pose")
    exists: exists_property("UPDATE")

    @classmethod
    def poll(cls, context):
        return ready(cls, context, writes=True)

    def begin(self, context):
        context.view_layer.update()
        if not self.name:
            raise Refused("Give the shape key a name first")
        self._request = request = _request(self, context)
        self._plan = destinations(request.target.objects(), [self.name], self.exists)
        if not any(self._plan):
            raise Refused(f"Shape key '{self.name}' exists, and If Exists is Skip: choose another name")
        rest = request.source.rest()
        with live.paused():
            self._shapes = Keys(rest, [(evaluated.now(request.source), rest)])
        known = request.known_fit() or (request.markers, request.options)
        return transfer_work(*request.geometry(), known, self._shapes.shapes, self.transfer_options())

    def finish(self, context, result):
        request = self._request
        request.source.find()
        targets = request.target.find()
        for target in targets:
            checks.require_writable(target)
        request.remember(context, result.fit)
        (delta,) = self._shapes.deltas(request.target.rest(), result.shapes)
        rows = zip(targets, request.target.parts, request.target.back(delta), self._plan, strict=True)
        written = []
        for obj, part, own, plan in rows:
            for name in without_empty(obj, {self.name: own}, plan, obj != targets[0]).values():
                shape_keys.write(obj, name, part.vertices + own)
                written.append(name)
        self.warn(request, result.fit, result.warnings, targets)
        if not self._shapes.shapes.size:
            self.report({"WARNING"}, "The source is at rest: the shape key moves nothing")
        self.report({"INFO"}, f"Shape key {first(dict.fromkeys(written))} on {where(targets)}")


class LISSOM_OT_transfer_animation(BakeProperties, TransferProperties, JobOperator, bpy.types.Operator):
    """Carry over what the source looks like at each frame of a range"""

    bl_idname = "lissom.transfer_animation"
    bl_label = "Transfer Animation"
    bl_options = {"REGISTER", "UNDO"}

    cache_path: StringProperty(**CACHE_FILE)

    @classmethod
    def poll(cls, context):
        return ready(cls, context, writes=True)

    def begin(self, context):
        context.view_layer.update()
        self._frames = frames = self.frames(context.scene)
        self._request = request = _request(self, context)
        targets = request.target.objects()
        self._require_free(targets)
        self._paths = self._cache_paths(targets) if self.output == "CACHE" else []
        counts = [len(part.vertices) for part in request.target.parts]
        self._results = [  # of each object: both kinds take the positions frame by frame
            cache.Writer(absolute, count, len(frames), frames[0], self.step)
            for (_, absolute), count in zip(self._paths, counts, strict=False)
        ] or [[] for _ in targets]
        known = request.known_fit() or (request.markers, request.options)
        steps = animation_steps(
            *request.geometry(),
            known,
            self._sampled(context.scene),
            len(frames),
            self.transfer_options(),
            self._take,
        )
        return Work(self._with_files(steps))

    def _require_free(self, targets):
        """Refused where a name is taken by what no transfer of that name made, or a key is locked."""
        wanted = self.key_names(self._frames) if self.output == "KEYS" else []
        for obj in targets:
            keys = obj.data.shape_keys.key_blocks if obj.data.shape_keys else {}
            ours = [row for row in obj.lissom_baked if row.bake == self.name]
            known = {row.name for row in ours if not row.cached}
            taken = [name for name in wanted if name in keys and name not in known]
            if taken:
                listed = first(repr(name) for name in taken)
                raise Refused(f"'{obj.name}' has a shape key {listed} already: choose another name")
            checks.require_unlocked([keys[name] for name in known if name in keys])
            played = {row.name for row in ours if row.cached}
            if self.output == "CACHE" and self.name in obj.modifiers and self.name not in played:
                raise Refused(f"'{obj.name}' has a modifier '{self.name}' already: choose another name")

    def _cache_paths(self, targets):
        """(as given, absolute) path of the cache of each object."""
        paths = [self.cache_path] * len(targets)
        if self.cache_path and len(targets) > 1:
            stem, ending = os.path.splitext(self.cache_path)
            paths = [f"{stem} {bpy.path.clean_name(obj.name)}{ending}" for obj in targets]
        found = [playback.cache_path(path, obj) for path, obj in zip(paths, targets, strict=True)]
        if len({absolute for _, absolute in found}) < len(found):
            raise Refused("Two objects of the target would get the same cache file: rename one of them")
        return found

    def _sampled(self, scene):
        """The source's shapes in blocks, each read from the scene when it is asked for."""
        name = scene.name
        for start in range(0, len(self._frames), BLOCK):
            scene = bpy.data.scenes.get(name)
            if scene is None or scene != bpy.context.scene:
                raise Refused(f"Scene '{name}' is not shown any more: nothing was changed")
            frames = self._frames[start : start + BLOCK]
            with live.paused():
                shapes = evaluated.sample(scene, self._request.source, frames, live.update)
            yield shapes

    def _take(self, block):
        target = self._request.target
        for shape in block:
            deltas = target.back(shape - target.rest())
            for result, part, own in zip(self._results, target.parts, deltas, strict=True):
                result.append((part.vertices + own).astype(np.float32))

    def _with_files(self, steps):
        with contextlib.ExitStack() as files:
            for writer in self._results if self._paths else ():
                files.enter_context(writer)
            return (yield from steps)

    def finish(self, context, result):
        request, (fit, warnings) = self._request, result
        try:
            request.source.find()
            targets = request.target.find()
            for target in targets:
                checks.require_writable(target)
            self._require_free(targets)
            for writer in self._results if self._paths else ():
                writer.commit()
        finally:
            for writer in self._results if self._paths else ():
                writer.discard()
        request.remember(context, fit)
        for place, target in enumerate(targets):
            self._remove_earlier(target)
            self._play(target, place)
        context.scene.frame_set(context.scene.frame_current, subframe=context.scene.frame_subframe)
        self.warn(request, fit, warnings, targets)
        self.report({"INFO"}, self.summary(where(targets), self._frames))

    def _remove_earlier(self, obj):
        for place in reversed(range(len(obj.lissom_baked))):
            row = obj.lissom_baked[place]
            if row.bake != self.name:
                continue
            if row.cached and row.name in obj.modifiers:
                obj.modifiers.remove(obj.modifiers[row.name])
            elif not row.cached and obj.data.shape_keys and row.name in obj.data.shape_keys.key_blocks:
                shape_keys.remove(obj, row.name)
            obj.lissom_baked.remove(place)

    def _play(self, obj, place):
        if self._paths:
            path = self._paths[place][0]
            made = [playback.play_cache(obj, self.name, path, self._frames[0], self.step)]
        else:
            rest = self._request.target.parts[place].vertices.astype(np.float32)
            if place and all(np.array_equal(shape, rest) for shape in self._results[place]):
                return  # a further object that does not move
            made = self.key_names(self._frames)
            for name, shape in zip(made, self._results[place], strict=True):
                shape_keys.write(obj, name, shape, shape_keys.Settings())
            playback.play_keys(obj, made, self._frames)
        for name in made:
            row = obj.lissom_baked.add()
            row.name, row.bake, row.cached = name, self.name, bool(self._paths)


classes = (LISSOM_OT_transfer_pose, LISSOM_OT_transfer_animation)
