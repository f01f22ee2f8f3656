"""``blender --command lissom transfer``: carries shape keys between objects of files, as the panel does."""

import json
import pathlib
import time

import bpy

from .. import session
from ..bridge import checks, shape_keys
from ..core.refused import Refused
from ..properties.transfer import EXISTS_ITEMS

SUMMARY = "carry the shape keys of one mesh over to another of different topology"
DONE, BAD_INPUT, PARTLY_DONE = 0, 2, 3


def configure(parser):
    """Adds the command's arguments to an argparse.ArgumentParser."""
    add = parser.add_argument
    add("--file", required=True, help="the .blend file with the target")
    add("--target", required=True, help="name of the mesh object that receives the keys")
    add("--source", required=True, help="name of the mesh object whose keys are carried over")
    add("--source-file", help="the .blend file with the source (default: that of the target)")
    add("--markers", default="", help="marker file (default: the markers in the file, if any)")
    add("--keys", nargs="+", default=[], help="names of the shape keys (default: all)")
    add("--exists", choices=[item[0].lower() for item in EXISTS_ITEMS], default="update")
    add("--loose-parts", choices=("follow", "rest"), default="follow", help="what parts without a match do")
    add("--match-distance", type=float, default=0.02, help="as a part of the target's diagonal (0.02)")
    add("--source-mask", default="", help="vertex group of the source that matches nothing")
    add("--target-mask", default="", help="vertex group of the target that matches nothing")
    add("--out", required=True, help="the .blend file to write")
    add("--report", help="also write what was done as JSON")


def run(arguments):
    """Reads, transfers, writes; returns the exit code."""
    started = time.perf_counter()
    try:
        _check(arguments)
        bpy.ops.wm.open_mainfile(filepath=_absolute(arguments.file), load_ui=False)
        target = checks.mesh_object(arguments.target, bpy.context)
        source, brought = _source(arguments)
        keys, unknown = _keys(source, arguments.keys)
        bpy.ops.lissom.transfer_keys(
            source=source.name,
            target=target.name,
            keys="\n".join(keys),
            filepath=_absolute(arguments.markers) if arguments.markers else "",
            exists=arguments.exists.upper(),
            unmatched=arguments.loose_parts,
            match_distance=arguments.match_distance,
            source_mask=arguments.source_mask,
            target_mask=arguments.target_mask,
        )
        report = {
            "source": source.name,
            "target": target.name,
            "keys": keys,
            "errors": [f"'{arguments.source}' has no shape key named '{name}'" for name in unknown],
            "fit": session.fit.fit.report,
            "seconds": round(time.perf_counter() - started, 3),
        }
        if brought:
            bpy.data.objects.remove(source)
        bpy.ops.wm.save_as_mainfile(filepath=_absolute(arguments.out), copy=True)
        if arguments.report:
            text = json.dumps(report, indent=2) + "\n"
            pathlib.Path(arguments.report).write_text(text, encoding="utf-8")
    except (Refused, RuntimeError, OSError) as error:
        print(f"Error: {str(error).removeprefix('Error: ').strip()}")
        return BAD_INPUT
    for error in report["errors"]:
        print(f"Error: {error}")
    print(f"{len(keys)} shape keys on '{target.name}'")
    return PARTLY_DONE if unknown else DONE


def _check(arguments):
    for name in ("file", "source_file", "markers"):
        path = getattr(arguments, name)
        if path and not pathlib.Path(path).is_file():
            raise Refused(f"--{name.replace('_', '-')}: there is no file '{path}'")
    for name in ("out", "report"):
        path = getattr(arguments, name)
        if path and not pathlib.Path(path).resolve().parent.is_dir():
            raise Refused(f"--{name}: there is no folder for '{path}'")
    if not 0 < arguments.match_distance <= 1:
        raise Refused("--match-distance: choose a part of the diagonal, above 0 and at most 1")


def _absolute(path):
    return str(pathlib.Path(path).resolve())


def _source(arguments):
    """The source object, and whether it was brought in from another file."""
    if not arguments.source_file or _absolute(arguments.source_file) == _absolute(arguments.file):
        return checks.mesh_object(arguments.source, bpy.context), False
    with bpy.data.libraries.load(_absolute(arguments.source_file), link=False) as (there, here):
        if arguments.source not in there.objects:
            raise Refused(f"There is no object named '{arguments.source}' in '{arguments.source_file}'")
        here.objects = [arguments.source]
    (source,) = here.objects
    bpy.context.scene.collection.objects.link(source)
    bpy.context.view_layer.update()
    return checks.mesh_object(source.name, bpy.context), True


def _keys(source, wanted):
    """The keys to carry over, and those that are not there."""
    there = shape_keys.key_names(source)
    if not wanted:
        return there, []
    known = [name for name in wanted if name in there]
    if not known:
        raise Refused(f"'{source.name}' has none of these shape keys: {', '.join(wanted)}")
    return known, [name for name in wanted if name not in there]
