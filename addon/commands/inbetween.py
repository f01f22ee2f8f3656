"""``blender --command lissom inbetween``: bakes arcs in a file, as the panel does."""

import time

import bpy
import lissom

from ..core.easing import EASINGS
from ..core.files import image_format
from ..core.inbetween import MAX_COUNT, PLAYBACK_ITEMS, ArcAsked
from ..core.options import argument
from ..core.refused import Refused
from ..jobs.arcs import arc_object, draw_sheet
from ..jobs.bake import Bake
from . import outputs

SUMMARY = "bake the arc between two shape keys as keys under one slider"
STEPS = 7  # of the contact sheet


def configure(parser):
    """Adds the command's arguments to an argparse.ArgumentParser."""
    add = parser.add_argument
    add("--file", required=True, help="the .blend file to read")
    add("--object", required=True, help="name of the mesh object")
    add("--start", default="", help="shape key that arcs start at (default: the Basis)")
    add("--end", required=True, nargs="+", help="shape keys that arcs lead to, an arc for each")
    keys = parser.add_mutually_exclusive_group()
    keys.add_argument("--count", type=int, help=f"in-betweens, 1 to {MAX_COUNT} (default: {ArcAsked.count})")
    keys.add_argument("--tolerance", type=float, help="the fewest keys within this distance, in scene units")
    for name in ("rotation", "stretch", "refinement", "preserve_volume"):
        add(f"--{name.replace('_', '-')}", **argument("inbetween", name))
    add("--through", default="", help="keys that arcs hit on their way, as 'half: 0.5, wide: 0.8'")
    add("--clearance", default="", help="name of a closed mesh object that arcs keep out of")
    add(
        "--easing",
        choices=[name.lower() for name in EASINGS],
        default="linear",
        help="how arcs run as the slider does",
    )
    add(
        "--playback",
        choices=[item[0].lower() for item in PLAYBACK_ITEMS],
        default="relative",
        help="how the keys are played",
    )
    add("--leave-animation", action="store_true", help="leave drivers and animation with the end key")
    add("--out", required=True, help="the .blend file to write")
    add("--sheet", help="also write a picture of the arcs beside the straight lines, .png or .jpg")
    add("--steps", type=int, default=STEPS, help="tiles in a row of that picture")
    add("--turn", type=float, default=30.0, help="degrees by which it looks from the side")
    outputs.add_report(add)


def run(arguments):
    """Reads, bakes, writes; returns the exit code."""
    started = time.perf_counter()
    try:
        _check(arguments)
        source = outputs.open_file(arguments.file)
        obj = arc_object(bpy.context, arguments.object)
    except (Refused, RuntimeError) as error:
        return _failed(str(error))
    baked = [_bake(obj, end, arguments) for end in arguments.end]
    done = [entry for entry in baked if "error" not in entry]
    try:
        if done:
            outputs.save(arguments.out)
            if arguments.sheet:
                names = [entry["slider"] for entry in done]
                draw_sheet(obj, names, arguments.sheet, arguments.steps, arguments.turn)
        warnings = [f"'{arc['end']}': {line}" for arc in done for line in arc["warnings"]]
        report = {"file": source, "object": obj.name, "arcs": baked, "warnings": warnings}
        errors = [f"'{arc['end']}': {arc['error']}" for arc in baked if "error" in arc]
        outputs.write_report(arguments, started, report, errors)
    except (Refused, RuntimeError, OSError) as error:
        _failed(str(error))
        return outputs.PARTLY_DONE if done else outputs.BAD_INPUT
    if len(done) == len(baked):
        return outputs.DONE
    return outputs.PARTLY_DONE if done else outputs.BAD_INPUT


def _check(arguments):
    outputs.check(arguments, ("file",), ("out", "sheet", "report"))
    if arguments.sheet:
        image_format(arguments.sheet)
    if not 2 <= arguments.steps <= 50:
        raise Refused("--steps: choose 2 to 50 tiles")
    if arguments.count is not None and not 1 <= arguments.count <= MAX_COUNT:
        raise Refused(f"--count: choose 1 to {MAX_COUNT} in-betweens")
    if not 0 <= arguments.refinement <= 1000:
        raise Refused("--refinement: choose 0 to 1000 rounds")
    if arguments.tolerance is not None and not 0 < arguments.tolerance < float("inf"):
        raise Refused("--tolerance: choose a distance above 0")


def _bake(obj, end, arguments):
    settings = {
        "start": arguments.start,
        "end": end,
        "rotation": arguments.rotation,
        "stretch": arguments.stretch,
        "refinement": arguments.refinement,
        "preserve_volume": arguments.preserve_volume,
        "through": arguments.through,
        "clearance": arguments.clearance,
        "easing": arguments.easing.upper(),
        "playback": arguments.playback.upper(),
        "reroute": not arguments.leave_animation,
    }
    if arguments.tolerance is not None:
        settings |= {"sampling": "TOLERANCE", "tolerance": arguments.tolerance}
    elif arguments.count is not None:
        settings["count"] = arguments.count
    report = settings | {name: settings[name].lower() for name in ("easing", "playback")}
    started = time.perf_counter()
    try:
        bake = Bake(bpy.context, ArcAsked(object=obj.name, **settings))
        done = bake.write(bpy.context, bake.work.wait())
    except lissom.Cancelled:
        raise
    except (Refused, lissom.Error) as error:
        _failed(f"'{end}': {error}")
        return report | {"error": str(error)}
    outputs.say_warnings(done.warnings)
    print(f"'{end}': {done.summary}")
    return report | {
        "slider": done.slider,
        "keys": [{"name": name, "time": at} for name, at in done.keys],
        "warnings": done.warnings,
        "seconds": round(time.perf_counter() - started, 3),
    }


def _failed(message):
    outputs.say_errors([message])
    return outputs.BAD_INPUT
