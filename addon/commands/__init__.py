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


class Help(argparse.HelpFormatter):
    """Help that begins with a capital, as the core's does, and says every default that counts."""

    def _get_help_string(self, action):
        told = (action.help or "").removesuffix(" (default: %(default)s)")  # Python's own, of switches
        default = action.default
        if isinstance(default, bool):
            default = ("off", "on")[default] if "--no-" in str(action.option_strings) else ""
        elif isinstance(default, float):
            default = f"{default:g}"
        shown = default not in (None, "", [], argparse.SUPPRESS) and "(default: " not in told
        return told[:1].upper() + told[1:] + (f" (default: {default})" if shown else "")


def parser():
    """The argparse.ArgumentParser of all commands."""
    made = argparse.ArgumentParser(
        prog="blender --command lissom", description="Lissom, without a window", formatter_class=Help
    )
    commands = made.add_subparsers(dest="command", required=True)
    for name, module in COMMANDS.items():
        told = {"help": module.SUMMARY, "description": module.SUMMARY}
        module.configure(commands.add_parser(name, formatter_class=Help, **told))
    return made


def main(words):
    """Runs one command line, without "lissom" itself; returns the exit code."""
    for word in words:
        try:
            word.encode()
        except UnicodeEncodeError:  # names and paths in Blender are UTF-8
            print(f"Error: {word!a} is not UTF-8: rename the file or folder first")
            return outputs.BAD_INPUT
    try:
        arguments = parser().parse_args(words)
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
