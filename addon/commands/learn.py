"""``blender --command lissom learn``: keys that were corrected by hand teach the others."""

import time
from dataclasses import asdict

import bpy

from ..core.options import argument
from ..core.refused import Refused
from ..jobs.learn import Learn, LearnAsked
from . import outputs

SUMMARY = "change shape keys as those that were corrected by hand since their transfer ask for"
STRONGEST = 2


def configure(parser):
    """Adds the command's arguments to an argparse.ArgumentParser."""
    add = parser.add_argument
    add("--file", required=True, help="the .blend file with the corrected keys")
    add("--target", required=True, help="mesh object that has them")
    add("--right", nargs="+", default=[], help="names of keys that need no correction: they teach as much")
    add("--strength", **argument("learn", "strength"))
    add("--out", help="the .blend file to write (default: only the report)")
    outputs.add_report(add)


def run(arguments):
    """Reads, learns, writes; returns the exit code."""
    started = time.perf_counter()
    outputs.check(arguments, ("file",), ("out", "report"))
    if not 0 <= arguments.strength <= STRONGEST:
        raise Refused(f"--strength: choose a number from 0 to {STRONGEST}")
    outputs.open_file(arguments.file)
    asked = LearnAsked(object=arguments.target, right="\n".join(arguments.right), strength=arguments.strength)
    job = Learn(bpy.context, asked)
    done = job.write(bpy.context, job.work.wait())
    if arguments.out:
        outputs.save(arguments.out)
    outputs.write_report(arguments, started, asdict(done))
    outputs.say(done)
    return outputs.DONE
