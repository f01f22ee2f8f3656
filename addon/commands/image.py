"""``blender --command lissom image``: a flat mesh of an image, or a second image at the end of its arc."""

import time
from dataclasses import asdict

import bpy

from ..core.image import LABELS
from ..core.options import argument, option
from ..core.refused import Refused
from ..jobs.image import ImageAsked, ImageMesh, lay_second
from . import outputs

SUMMARY = "make a flat mesh of an image, or lay a second image under the end of its arc"


def configure(parser):
    """Adds the command's arguments to an argparse.ArgumentParser."""
    add = parser.add_argument
    what = parser.add_mutually_exclusive_group(required=True)
    what.add_argument("--image", help="the image to make a mesh of")
    what.add_argument("--second", help="the image to lay under the end of an arc of --object in --file")
    add("--file", help="the .blend file to read (default: an empty one)")
    add("--out", required=True, help="the .blend file to write")
    for name in LABELS:
        add(f"--{name}", **argument("image_mesh", name))
    add("--height", type=float, default=2.0, help="height of the whole image in scene units")
    add("--object", default="", help="name of the mesh object that gets the second image")
    add("--slider", default="", help="slider of its arc (default: that of the last one)")
    outputs.add_report(add)


def run(arguments):
    """Reads, makes, writes; returns the exit code."""
    started = time.perf_counter()
    _check(arguments)
    if arguments.file:
        outputs.open_file(arguments.file)
    else:
        bpy.ops.wm.read_factory_settings(use_empty=True)
    image = outputs.absolute(arguments.image or arguments.second)
    if arguments.image:
        asked = {name: getattr(arguments, name) for name in LABELS}
        job = ImageMesh(bpy.context, ImageAsked(filepath=image, height=arguments.height, **asked))
        done = job.write(bpy.context, job.work.wait())
    else:
        done = lay_second(bpy.context, arguments.object, arguments.slider, filepath=image)
    outputs.save(arguments.out)
    outputs.write_report(arguments, started, asdict(done))
    outputs.say(done)
    return outputs.DONE


def _check(arguments):
    outputs.check(arguments, ("image", "second", "file"), ("out", "report"))
    if arguments.second and not (arguments.file and arguments.object):
        raise Refused("--second: say by --file and --object which mesh gets it")
    if not arguments.height > 0:
        raise Refused("--height: choose a height above 0")
    outputs.check_ranges(arguments, {name: option("image_mesh", name, "") for name in LABELS})
