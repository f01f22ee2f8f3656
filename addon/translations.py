"""The extension in the language that Blender is set to.

What Blender draws by itself (labels, tooltips, names of properties) it translates by the table that is
registered here; messages that are made of several parts go through ``translated``. What the core says in a
programmer's words, of vertices by number, is said in an artist's first.
"""

import json
import pathlib
import re

import bpy

from .core.wording import Catalogue, singular

FOLDER = pathlib.Path(__file__).with_name("locale")
CONTEXT = "Lissom"  # of words that mean something else in Blender
CONTEXTS = ("*", "Operator", CONTEXT)  # of labels and tooltips, of buttons, and our own

PLAIN = json.loads(pathlib.Path(__file__).with_name("plain_words.json").read_text(encoding="utf-8"))

_plain = Catalogue(PLAIN)
_catalogues = {}


def language():
    """The code of the language that Blender's interface is in, such as ``zh_HANS``; "" for English alone."""
    spoken = bpy.context.preferences.view.use_translate_interface
    return bpy.app.translations.locale if spoken else ""


def translated(text):
    """A text or a finished message in plain words, and in Blender's language where there is one of ours."""
    catalogue, plain = _catalogues.get(language()), _plain.said(text)
    return catalogue.said(plain) if catalogue else singular(plain)


def _indented(text):
    """A docstring as it stands in the source, which Python takes the indentation from only since 3.13."""
    return re.sub(r"\n(?=[^\n])", "\n    ", text)


def register():
    registered = {}
    for file in FOLDER.glob("*.json"):
        table = json.loads(file.read_text(encoding="utf-8"))
        _catalogues[file.stem] = Catalogue(table)
        registered[file.stem] = {
            (context, spelled): said
            for text, said in table.items()
            for spelled in (text, _indented(text))
            for context in CONTEXTS
        }
    bpy.app.translations.register(__name__, registered)


def unregister():
    bpy.app.translations.unregister(__name__)
    _catalogues.clear()
