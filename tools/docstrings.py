"""Makes Markdown of the docstrings, for the site: what they say of an argument becomes an item of a list.

Docstrings are written to be read in an editor: ``name: what it is``, further lines indented, and roles such
as ``:func:`lissom.image_mesh` ``. mkdocs.yml names this file as an extension of griffe.
"""

import re

import griffe

ARGUMENT = re.compile(r"^(?P<names>\w+(?:, \w+)*): (?P<text>.+(?:\n[ ]{4,}.+)*)", re.MULTILINE)
ROLE = re.compile(r":\w+:`([^`]+)`")


def markdown(text):
    """The docstring as Markdown."""
    text = ARGUMENT.sub(lambda found: f"- `{found['names']}`: {found['text']}", ROLE.sub(r"`\1`", text))
    return re.sub(r"(?m)^(?!- |$|\s)(.*)\n(?=- )", r"\1\n\n", text)


class Docstrings(griffe.Extension):
    """Rewrites the docstring of every object that is documented."""

    def on_object(self, *, obj, **_):
        """Called by griffe for each of them once its members are there."""
        if obj.docstring:
            obj.docstring.value = markdown(obj.docstring.value)
