"""``blender --command lissom transfer``: carries shape keys between objects of files, as the panel does."""

import time
from dataclasses import asdict

import bpy

from ..core import bake
from ..core.options import argument
from ..core.refused import Refused
from ..core.transfer_options import FLAGS, MASKS, OPTIONS
from ..jobs.brought import Brought, mesh_objects
from ..jobs.fit import key_names
from ..jobs.transfer_keys import KeysAsked, TransferKeys
from ..jobs.transfer_pose import AnimationAsked, PoseAsked, TransferAnimation, TransferPose
from . import outputs, strengths

SUMMARY = "carry shape keys, a pose or animation of one mesh over to another of different topology"
MAX_FRAME = 1_048_574
_OPTIONS = {name: one for own in OPTIONS.values() for name, one in own.items()}


def configure(parser):
    """Adds the command's arguments to an argparse.ArgumentParser."""
    add = parser.add_argument
    add("--file", required=True, help="the .blend file with the target")
    add("--target", required=True, nargs="+", help="mesh object that gets the keys, and further ones")
    add("--source", required=True, nargs="+", help="mesh object with the keys, and further ones")
    add("--source-file", help="the .blend file with the source (default: that of the target)")
    add("--markers", default="", help="marker file (default: the file's markers; without any, the shapes)")
    what = parser.add_mutually_exclusive_group().add_argument
    what("--keys", nargs="+", default=[], help="names of the shape keys (default: all)")
    what("--pose", metavar="NAME", help="in place of keys: what the source looks like, as this shape key")
    what(
        "--frames",
        nargs="+",
        type=int,
        metavar="FRAME",
        help="in place of keys: what the source looks like from the first to the last of these frames; a "
        "third number is the step",
    )
    add("--cache", help="with --frames: the point cache to write (default: shape keys)")
    outputs.add_there(add)
    add("--drivers", choices=("rewire", "keep", "none"), default="rewire", help="what becomes of drivers")
    strengths.configure(add)
    add("--drop-empty", action="store_true", help="leave out keys that do not move the target")
    for owner, options in OPTIONS.items():
        for name in options:
            add(f"--{FLAGS.get(name, name).replace('_', '-')}", **argument(owner, name))
    for mask in MASKS:
        side = mask.partition("_")[0]
        add(f"--{side}-mask", default="", help=f"vertex group of the {side} that matches nothing")
    add("--out", required=True, help="the .blend file to write")
    outputs.add_report(add)


def run(arguments):
    """Reads, transfers, writes; returns the exit code."""
    started = time.perf_counter()
    _check(arguments)
    wanted = strengths.read(arguments)
    outputs.open_file(arguments.file)
    arguments.target = list(dict.fromkeys(arguments.target))
    targets = mesh_objects(bpy.context, arguments.target)
    brought = Brought(bpy.context, arguments.source, _source_file(arguments))
    sources = brought.objects
    transfer = next((run for name, run in INSTEAD.items() if getattr(arguments, name)), _transfer_keys)
    report = {"source": [source.name for source in sources], "target": arguments.target}
    done, what, errors = transfer(arguments, sources, _common(arguments, sources))
    fit = done.fit.fit.report
    report |= what | {"fit": fit, "certainty": fit["certainty"], "doubtful_markers": done.doubtful_markers}
    errors += brought.send_back(targets)
    errors += strengths.apply(bpy.context, wanted, targets)
    outputs.save(arguments.out)
    outputs.write_report(arguments, started, report | {"warnings": done.warnings}, errors)
    outputs.say_quality(report.get("quality", ()))
    print(f"{_done(report)} on {', '.join(repr(target.name) for target in targets)}")
    return outputs.say_errors(errors)


def _common(arguments, sources):
    """What is asked for whatever is carried over."""
    return {
        "source": "\n".join(source.name for source in sources),
        "target": "\n".join(arguments.target),
        "filepath": outputs.absolute(arguments.markers) if arguments.markers else "",
        **{name: getattr(arguments, FLAGS.get(name, name)) for name in (*_OPTIONS, *MASKS)},
    }


def _run(job):
    done = job.write(bpy.context, job.work.wait())
    outputs.say_warnings(done.warnings)
    return done


def _found(arguments, done):
    """What was there already: by object, the keys that were locked or edited."""
    return {"there": asdict(done.found) | {"edited_keys": arguments.edited}}


def _transfer_keys(arguments, sources, common):
    keys, unknown = _keys(sources, arguments.keys)
    asked = KeysAsked(
        keys=tuple(keys),
        exists=arguments.exists.upper(),
        edited=arguments.edited.upper(),
        drivers=arguments.drivers.upper(),
        drop_empty=arguments.drop_empty,
        **common,
    )
    done = _run(TransferKeys(bpy.context, asked))
    errors = [f"'{arguments.source[0]}' has no shape key named '{name}'" for name in unknown]
    return done, {"keys": keys, "quality": done.quality} | _found(arguments, done), errors


def _transfer_pose(arguments, sources, common):
    what = {"exists": arguments.exists.upper(), "edited": arguments.edited.upper()}
    done = _run(TransferPose(bpy.context, PoseAsked(name=arguments.pose, **what, **common)))
    return done, {"pose": arguments.pose} | _found(arguments, done), []


def _transfer_frames(arguments, sources, common):
    start, end, step = (*arguments.frames, 1)[:3]
    frames = bake.frames(start, end, step, keys=not arguments.cache)
    asked = AnimationAsked(frames=frames, step=step, **common)
    if arguments.cache:
        asked.cache_path = outputs.absolute(arguments.cache)
    else:
        asked.keys = tuple(bake.key_names(asked.name, frames))
    done = _run(TransferAnimation(bpy.context, asked))
    return done, {"frames": frames, "caches": done.caches}, []


INSTEAD = {"pose": _transfer_pose, "frames": _transfer_frames}


def _done(report):
    if "pose" in report:
        return f"Shape key '{report['pose']}'"
    return f"{len(report['frames'])} frames" if "frames" in report else f"{len(report['keys'])} shape keys"


def _check(arguments):
    outputs.check(arguments, ("file", "source_file", "markers"), ("out", "report", "cache"))
    for name in (*arguments.source, *arguments.target):
        if "\n" in name:  # operators are told names one a line
            raise Refused(f"{name!r}: there is a line break in this name: rename the object first")
    if arguments.pose == "":
        raise Refused("--pose: give the shape key a name")
    if arguments.frames and (len(arguments.frames) not in (2, 3) or not _are_frames(arguments.frames)):
        raise Refused(
            "--frames: give the first and the last frame, and the step, 1 to 1000, if it is not 1; "
            f"Blender's frames go to {MAX_FRAME}"
        )
    if arguments.cache and not arguments.frames:
        raise Refused("--cache: it keeps what --frames makes: give the frames too")
    outputs.check_ranges(arguments, {FLAGS.get(name, name): one for name, one in _OPTIONS.items()})


def _source_file(arguments):
    """The path of the source's file, "" where that is the target's."""
    path = outputs.absolute(arguments.source_file) if arguments.source_file else ""
    return "" if path == outputs.absolute(arguments.file) else path


def _are_frames(frames):
    within = all(-MAX_FRAME <= frame <= MAX_FRAME for frame in frames[:2])
    return within and all(1 <= step <= 1000 for step in frames[2:])


def _keys(sources, wanted):
    """The keys to carry over, and those that are not there."""
    there = key_names(sources)
    if not wanted:
        return there, []
    known = [name for name in wanted if name in there]
    if not known:
        raise Refused(f"'{sources[0].name}' has none of these shape keys: {', '.join(wanted)}")
    return known, [name for name in wanted if name not in there]
