"""Transfer of what the source looks like: of a pose as a shape key, of a range of frames as animation."""

import contextlib
import os
from dataclasses import dataclass

import bpy
import numpy as np

from .. import session
from ..bridge import checks, evaluated, playback, shape_keys
from ..core import cache
from ..core.refused import Refused, first
from ..core.transfer import Keys, animation_steps, transfer_work
from ..core.work import Work
from . import bound
from .corrections import Corrections, Found
from .fit import FitDone, Request, TransferAsked, where
from .transfer_keys import destinations, without_empty

BLOCK = 32  # frames that are in memory at a time


@dataclass(kw_only=True)
class PoseAsked(TransferAsked):
    """What a transfer of a pose is made of."""

    name: str = "Pose"  # of the shape key
    exists: str = "UPDATE"
    edited: str = "KEEP"


@dataclass(kw_only=True)
class AnimationAsked(TransferAsked):
    """What a transfer of animation is made of."""

    name: str = "Pose"  # of the modifier, or of what is baked
    frames: list[int]
    step: int = 1  # between them
    keys: tuple[str, ...] = ()  # names of the shape keys, one a frame; none: a cache
    cache_path: str = ""


@dataclass(kw_only=True)
class PoseDone(FitDone):
    """``written``: the name of the key on each object that has got it; ``found`` as in KeysDone."""

    written: dict[str, str]
    found: Found


@dataclass(kw_only=True)
class AnimationDone(FitDone):
    """``caches``: the file of each object, as its modifier has it; none for shape keys."""

    frames: list[int]
    caches: list[str]


def _at_rest(context, asked):
    """The Request of meshes at rest, on objects where armatures at rest leave them; targets are writable."""
    context.view_layer.update()
    with session.paused(), evaluated.at_rest():
        request = Request(context, asked)
    request.require_writable()
    return request


class TransferPose:
    """What the source looks like now, by armature, modifiers and shape keys, as one shape key."""

    def __init__(self, context, asked):
        if not asked.name:
            raise Refused("Give the shape key a name first")
        self._name = asked.name
        self._request = request = _at_rest(context, asked)
        self._plan = destinations(request.target.objects(), [asked.name], asked.exists)
        if not any(self._plan):
            raise Refused(f"Shape key '{asked.name}' exists, and If Exists is Skip: choose another name")
        self._corrections = Corrections(asked.edited)
        self._plan = self._corrections.leave(request.target.objects(), self._plan)
        self._corrections.require_any(self._plan)
        rest = request.source.rest()
        with session.paused():
            self._shapes = Keys(rest, [(evaluated.now(request.source), rest)])
        self.work = transfer_work(*request.geometry(), request.fit(), self._shapes.shapes, asked.options)

    def write(self, context, result):
        """Writes a core.transfer.Carried; a PoseDone."""
        request = self._request
        request.source.find()
        targets = request.require_writable()
        self._plan = self._corrections.leave(targets, self._plan)
        fit = request.remember(context, result.fit)
        (delta,) = self._shapes.deltas(request.target.rest(), result.shapes)
        rows = zip(targets, request.target.parts, request.target.back(delta), self._plan, strict=True)
        written = {}
        for obj, part, own, plan in rows:
            for name in without_empty(obj, {self._name: own}, plan, obj != targets[0]).values():
                shape_keys.ensure_basis(obj)
                self._corrections.writer(obj, part.triangles).write(name, part.vertices, own)
                written[obj.name] = name
        warnings = [
            *self._corrections.warnings(),
            *request.told_of_transfer(result.fit, result.warnings),
        ]
        if not self._shapes.shapes.size:
            warnings.append("The source is at rest: the shape key moves nothing")
        return PoseDone(
            summary=f"Shape key {first(map(repr, dict.fromkeys(written.values())))} on {where(targets)}",
            warnings=warnings,
            fit=fit,
            written=written,
            found=self._corrections.found,
        )


class TransferAnimation:
    """What the source looks like at each frame of a range, as shape keys that play or as a point cache."""

    def __init__(self, context, asked):
        self._asked, self._frames = asked, asked.frames
        self._request = request = _at_rest(context, asked)
        targets = request.target.objects()
        self._require_free(targets)
        self._paths = [] if asked.keys else self._cache_paths(targets)
        counts = [len(part.vertices) for part in request.target.parts]
        self._results = [  # of each object: both kinds take the positions frame by frame
            cache.Writer(absolute, count, len(asked.frames), asked.frames[0], asked.step)
            for (_, absolute), count in zip(self._paths, counts, strict=False)
        ] or [[] for _ in targets]
        sampled = self._sampled(context.scene)
        steps = animation_steps(
            *request.geometry(), request.fit(), sampled, len(asked.frames), asked.options, self._take
        )
        self.work = Work(self._with_files(steps))

    def _require_free(self, targets):
        """Refused where a name is taken by what no transfer of that name made, or a key is locked."""
        name = self._asked.name
        for obj in targets:
            keys = obj.data.shape_keys.key_blocks if obj.data.shape_keys else {}
            ours = [row for row in obj.lissom_baked if row.bake == name]
            known = {row.name for row in ours if not row.cached}
            taken = [key for key in self._asked.keys if key in keys and key not in known]
            if taken:
                listed = first(map(repr, taken))
                raise Refused(f"'{obj.name}' has a shape key {listed} already: choose another name")
            checks.require_unlocked([keys[key] for key in known if key in keys])
            played = {row.name for row in ours if row.cached}
            if not self._asked.keys and name in obj.modifiers and name not in played:
                raise Refused(f"'{obj.name}' has a modifier '{name}' already: choose another name")

    def _cache_paths(self, targets):
        """(as given, absolute) path of the cache of each object."""
        given = self._asked.cache_path
        paths = [given] * len(targets)
        if given and len(targets) > 1:
            stem, ending = os.path.splitext(given)
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
            with session.paused():
                shapes = evaluated.sample(scene, self._request.source, frames, bound.follow)
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

    def write(self, context, result):
        """Writes what animation_steps has left to be written, and takes (fit, warnings); an AnimationDone."""
        request, (fit, warnings) = self._request, result
        try:
            request.source.find()
            targets = request.require_writable()
            self._require_free(targets)
            for writer in self._results if self._paths else ():
                writer.commit()
        finally:
            for writer in self._results if self._paths else ():
                writer.discard()
        memory = request.remember(context, fit)
        for place, target in enumerate(targets):
            self._remove_earlier(target)
            self._play(target, place)
        context.scene.frame_set(context.scene.frame_current, subframe=context.scene.frame_subframe)
        first_frame, last_frame = self._frames[0], self._frames[-1]
        what = "a point cache" if self._paths else f"{len(self._frames)} shape keys"
        return AnimationDone(
            summary=f"{where(targets)} plays frames {first_frame} to {last_frame} from {what}",
            warnings=request.told_of_transfer(fit, warnings),
            fit=memory,
            frames=self._frames,
            caches=[path for path, _ in self._paths],
        )

    def _remove_earlier(self, obj):
        for place in reversed(range(len(obj.lissom_baked))):
            row = obj.lissom_baked[place]
            if row.bake != self._asked.name:
                continue
            if row.cached and row.name in obj.modifiers:
                obj.modifiers.remove(obj.modifiers[row.name])
            elif not row.cached and obj.data.shape_keys and row.name in obj.data.shape_keys.key_blocks:
                shape_keys.remove(obj, row.name)
            obj.lissom_baked.remove(place)

    def _play(self, obj, place):
        if self._paths:
            path = self._paths[place][0]
            made = [playback.play_cache(obj, self._asked.name, path, self._frames[0], self._asked.step)]
        else:
            rest = self._request.target.parts[place].vertices.astype(np.float32)
            if place and all(np.array_equal(shape, rest) for shape in self._results[place]):
                return  # a further object that does not move
            made = self._asked.keys
            for name, shape in zip(made, self._results[place], strict=True):
                shape_keys.write(obj, name, shape, shape_keys.Settings())
            playback.play_keys(obj, made, self._frames)
        for name in made:
            row = obj.lissom_baked.add()
            row.name, row.bake, row.cached = name, self._asked.name, bool(self._paths)
