"""``blender --command lissom transfer``: carries shape keys between objects of files, as the panel does."""

import json
import pathlib
import time

import bpy

from .. import session
from ..bridge import checks
from ..core.refused import Refused
from ..operators.transfer_fit import key_names
from ..operators.transfer_parts import quality_rows
from ..properties.transfer import EXISTS_ITEMS

SUMMARY = "carry the shape keys of one mesh over to another of different topology"
DONE, BAD_INPUT, PARTLY_DONE = 0, 2, 3


def configure(parser):
    """Adds the command's arguments to an argparse.ArgumentParser."""
    add = parser.add_argument
    add("--file", required=True, help="the .blend file with the target")
    add("--target", required=True, nargs="+", help="mesh object that gets the keys, and further ones")
    add("--source", required=True, nargs="+", help="mesh object with the keys, and further ones")
    add("--source-file", help="the .blend file with the source (default: that of the target)")
    add("--markers", default="", help="marker file (default: the markers in the file, if any)")
    add("--keys", nargs="+", default=[], help="names of the shape keys (default: all)")
    add("--exists", choices=[item[0].lower() for item in EXISTS_ITEMS], default="update")
    add("--loose-parts", choices=("follow", "rest"), default="follow", help="what parts without a match do")
    add("--drivers", choices=("rewire", "keep", "none"), default="rewire", help="what becomes of drivers")
    add("--contact", action="store_true", help="lids and lips that meet on the source meet on the target")
    add("--drop-empty", action="store_true", help="leave out keys that do not move the target")
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
        targets = [checks.mesh_object(name, bpy.context) for name in arguments.target]
        sources, brought = _sources(arguments)
        keys, unknown = _keys(sources, arguments.keys)
        bpy.ops.lissom.transfer_keys(
            source="\n".join(source.name for source in sources),
            target="\n".join(arguments.target),
            keys="\n".join(keys),
            filepath=_absolute(arguments.markers) if arguments.markers else "",
            exists=arguments.exists.upper(),
            unmatched=arguments.loose_parts,
            drivers=arguments.drivers.upper(),
            contact=arguments.contact,
            drop_empty=arguments.drop_empty,
            match_distance=arguments.match_distance,
            source_mask=arguments.source_mask,
            target_mask=arguments.target_mask,
        )
        report = {
            "source": [source.name for source in sources],
            "target": arguments.target,
            "keys": keys,
            "errors": [f"'{arguments.source[0]}' has no shape key named '{name}'" for name in unknown],
            "fit": session.fit.fit.report,
            "quality": quality_rows(bpy.context.scene),
            "seconds": round(time.perf_counter() - started, 3),
        }
        for source in sources if brought else ():
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
    print(f"{len(keys)} shape keys on {', '.join(repr(target.name) for target in targets)}")
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


def _sources(arguments):
    """The source objects, and whether they were brought in from another file."""
    if not arguments.source_file or _absolute(arguments.source_file) == _absolute(arguments.file):
        return [checks.mesh_object(name, bpy.context) for name in arguments.source], False
    with bpy.data.libraries.load(_absolute(arguments.source_file), link=False) as (there, here):
        missing = [name for name in arguments.source if name not in there.objects]
        if missing:
            raise Refused(f"There is no object named '{missing[0]}' in '{arguments.source_file}'")
        here.objects = list(arguments.source)
    for source in here.objects:
        bpy.context.scene.collection.objects.link(source)
    bpy.context.view_layer.update()
    return [checks.mesh_object(source.name, bpy.context) for source in here.objects], True


def _keys(sources, wanted):
    """The keys to carry over, and those that are not there."""
    there = key_names(sources)
    if not wanted:
        return there, []
    known = [name for name in wanted if name in there]
    if not known:
        raise Refused(f"'{sources[0].name}' has none of these shape keys: {', '.join(wanted)}")
    return known, [name for name in wanted if name not in there]
