"""Makes Markdown of the docstrings, for the site: what they say of an argument becomes an item of a list.

Docstrings are written to be read in an editor: ``name: what it is`` where a paragraph begins or below another
argument, further lines indented, and roles such as ``:func:`lissom.image_mesh` ``. A line that begins so
elsewhere is a sentence that was broken there. mkdocs.yml names this file as an extension of griffe.
"""

import re

import griffe

_ONE = r"\w+(?:, \w+)*: .+(?:\n[ ]{4,}.+)*"
ARGUMENTS = re.compile(rf"(?:\A|(?<=\n\n)){_ONE}(?:\n{_ONE})*")
NAMES = re.compile(r"^(\w+(?:, \w+)*): ", re.MULTILINE)
ROLE = re.compile(r":\w+:`([^`]+)`")


def markdown(text):
    """The docstring as Markdown."""
    return ARGUMENTS.sub(lambda found: NAMES.sub(r"- `\1`: ", found[0]), ROLE.sub(r"`\1`", text))


class Docstrings(griffe.Extension):
    """Rewrites the docstring of every object that is documented."""

    def on_object(self, *, obj, **_):
        """Called by griffe for each of them once its members are there."""
        if obj.docstring:
            obj.docstring.value = markdown(obj.docstring.value)
