"""``blender --command lissom face``: gives a head the shape keys of a whole face, as Face Keys does."""

import time
from dataclasses import asdict

import bpy
from lissom import names

from ..core.face_parts import KINDS
from ..core.options import argument
from ..core.refused import Refused
from ..jobs.brought import mesh_objects
from ..jobs.face import FaceAsked, FaceKeys
from . import outputs, strengths

SUMMARY = "give a head the shape keys of a whole face, found by its shape alone"
KINDS_HELP = f"what parts are where their shape misleads, as EYE=Lamp: {', '.join(KINDS)}"
NEXT = (
    "Say by --landmarks where the face is, or press Face Keys in Blender's window, set the landmarks that it "
    "asks for, and save the file"
)


def configure(parser):
    """Adds the command's arguments to an argparse.ArgumentParser."""
    add = parser.add_argument
    add("--file", required=True, help="the .blend file with the head")
    add("--target", required=True, help="mesh object of the head, upright and looking along -Y")
    add("--parts", nargs="+", default=[], help="further objects, as eyes, teeth and lashes")
    add(
        "--names",
        choices=[name.lower() for name in names.SETS],
        default="arkit",
        help="what the keys are called",
    )
    outputs.add_there(add)
    add("--contact", **argument("transfer", "contact"))
    add("--landmarks", help="JSON of landmarks that an outside detector has found on the head")
    add("--kinds", nargs="+", default=[], metavar="KIND=OBJECT", help=KINDS_HELP)
    add("--strength", type=float, default=1.0, help="of all keys")
    strengths.configure(add)
    add("--out", required=True, help="the .blend file to write")
    outputs.add_report(add)


def run(arguments):
    """Reads, makes the keys, writes; returns the exit code."""
    started = time.perf_counter()
    outputs.check(arguments, ("file", "landmarks"), ("out", "report"))
    if not 0 <= arguments.strength <= 10:
        raise Refused("--strength: choose a number from 0 to 10")
    wanted = strengths.read(arguments)
    outputs.open_file(arguments.file)
    asked = FaceAsked(
        target=arguments.target,
        parts="\n".join(arguments.parts),
        names=arguments.names.upper(),
        exists=arguments.exists.upper(),
        edited=arguments.edited.upper(),
        contact=arguments.contact,
        strength=arguments.strength,
        landmarks=arguments.landmarks or "",
        kinds=_kinds(arguments.kinds),
    )
    job = FaceKeys(bpy.context, asked)
    done = job.write(bpy.context, job.work.wait())
    errors = []
    if not done.stopped:
        objects = mesh_objects(bpy.context, [arguments.target, *arguments.parts])
        errors = strengths.apply(bpy.context, wanted, objects)
        outputs.save(arguments.out)
    fit = {"fit": done.report, "certainty": done.sure}
    outputs.write_report(arguments, started, asdict(done) | fit, errors)
    if done.stopped:
        outputs.say_errors([f"{done.summary}. {NEXT}"])
        return outputs.BAD_INPUT
    outputs.say(done)
    return outputs.say_errors(errors)


def _kinds(told):
    """As FaceAsked has them."""
    for words in told:
        if "=" not in words:
            raise Refused(f"--kinds: '{words}' is no KIND=OBJECT, as EYE=Lamp")
    return "\n".join(words.replace("=", " ", 1) for words in told)
