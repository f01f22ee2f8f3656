"""``blender --command lissom ...``: a command is a module with SUMMARY, configure(parser) and run(arguments).

Exit codes are those of ``outputs``.
"""

import argparse

import bpy
import lissom

from ..core.refused import Refused
from . import face, image, inbetween, learn, outputs, transfer

COMMANDS = {"face": face, "image": image, "inbetween": inbetween, "learn": learn, "transfer": transfer}

_handle = None


def main(words):
    """Runs one command line, without "lissom" itself; returns the exit code."""
    parser = argparse.ArgumentParser(prog="blender --command lissom", description="Lissom, without a window")
    commands = parser.add_subparsers(dest="command", required=True)
    for name, module in COMMANDS.items():
        module.configure(commands.add_parser(name, help=module.SUMMARY, description=module.SUMMARY))
    for word in words:
        try:
            word.encode()
        except UnicodeEncodeError:  # names and paths in Blender are UTF-8
            print(f"Error: {word!a} is not UTF-8: rename the file or folder first")
            return outputs.BAD_INPUT
    try:
        arguments = parser.parse_args(words)
    except SystemExit as end:  # argparse has said why; --help ends with 0
        return int(end.code or 0)
    try:
        return COMMANDS[arguments.command].run(arguments)
    except (KeyboardInterrupt, lissom.Cancelled):
        print("Cancelled")
        return outputs.CANCELLED
    except (Refused, lissom.Error, RuntimeError, OSError) as error:
        outputs.say_errors([str(error)])
        return outputs.BAD_INPUT


def register():
    global _handle
    _handle = bpy.utils.register_cli_command("lissom", main)


def unregister():
    global _handle
    bpy.utils.unregister_cli_command(_handle)
    _handle = None
