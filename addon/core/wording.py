"""Texts in another language, and texts broken into lines.

A finished message is found again by the template that it was made of: a table maps ``There is no object named
'{0}'`` to the same in another language. So no caller knows about languages, and messages of the core, which
come finished, are spoken too. What stands in single quotes is a name and stays; other values that the table
knows are spoken as well.
"""

import functools
import re

ARGUMENT = re.compile(r"([a-z_]+): ")  # how the core's messages begin
PLACES = "{0} (at {1}; {2} in all)"  # and how those end that are of single vertices
FIELD = re.compile(r"('?)\{(\d+)\}('?)")
# What messages count, told of one: names in quotes are not counted.
COUNTED = re.compile(
    r"(?<![\w.,'])1 ((?:[a-z]+ )?)(keys|faces|triangles|sliders|attributes|landmarks|objects|pairs|curves|"
    r"vertices|frames)\b(?! (?:are|have))"
)
# Languages without spaces break between any two signs, but not before one that closes.
_UNIT = re.compile(
    r"[\u2e80-\u9fff\uff00-\uffef\u201c(]*?[\u2e80-\u9fff\uff00-\uffef][\u3001-\u301f\uff00-\uff65\u201d]*"
    r"|[^\s\u2e80-\u9fff\uff00-\uffef]+|\s+"
)


class Catalogue:
    """Templates in English, each with its form in another language."""

    def __init__(self, table):
        """``table``: {template: the same in the other language}, values as ``{0}``, ``{1}`` and so on."""
        self._exact = {text: said for text, said in table.items() if not FIELD.search(text)}
        made = [text for text in table if FIELD.search(text)]
        # The one that says most is tried first; what stands behind a message is no part of its last value.
        made.sort(key=lambda text: (text != PLACES, -len(FIELD.sub("", text))))
        self._templates = [(_pattern(text), *_names(text), table[text]) for text in made]
        self._places = made.index(PLACES) if PLACES in made else -1
        self.said = functools.lru_cache(maxsize=1024)(self._said)

    def _said(self, text):
        """A message in the other language; what is not known stays as it is."""
        if not text or text in self._exact:
            return self._exact.get(text, text)
        place, found = self._match(text)
        argument = ARGUMENT.match(text)
        if argument and self._says_more(text[argument.end() :], place):
            return f"{self.said(argument[1])}: {self.said(text[argument.end() :])}"
        if found:
            _, numbers, names, said = self._templates[place]
            values = [
                value if name else self.said(value) for value, name in zip(found.groups(), names, strict=True)
            ]
            return _filled(said, dict(zip(numbers, values, strict=True)))
        for mark in (". ", "; ", ": "):  # sentences, and warnings that begin with what they are about
            head, found, rest = text.partition(mark)
            if found and head and rest:
                return f"{self.said(head)}{mark}{self.said(rest)}"
        return text

    def _match(self, text):
        """The place of the template that a message was made of, and its match: behind all, None."""
        for place, (pattern, _, names, _) in enumerate(self._templates):
            found = pattern.fullmatch(text)
            if found and (place == self._places or not _takes_more(found, names)):
                return place, found
        return len(self._templates), None

    def _says_more(self, text, place):
        """Whether a message is known by more than the template at this place."""
        return text in self._exact or self._match(text)[0] < place


def singular(text):
    """An English message in which one thing is counted as one: 1 shape key, not 1 shape keys."""
    return COUNTED.sub(lambda found: f"1 {found[1]}{_of_one(found[2])}", text)


def _of_one(plural):
    return "vertex" if plural == "vertices" else plural.removesuffix("s")


def _takes_more(found, names):
    """Whether a value of a match is another message and a part of this one."""
    return any("; " in value for value, name in zip(found.groups(), names, strict=True) if not name)


def _pattern(template):
    parts = FIELD.split(template)
    regex = re.escape(parts[0])
    for before, _, after, text in zip(parts[1::4], parts[2::4], parts[3::4], parts[4::4], strict=True):
        regex += f"{before}(.*?){after}{re.escape(text)}"
    return re.compile(regex, re.DOTALL)


def _names(template):
    found = FIELD.findall(template)
    return [int(number) for _, number, _ in found], [bool(before and after) for before, _, after in found]


def _filled(said, values):
    return re.sub(r"\{(\d+)\}", lambda field: values[int(field[1])], said)


def lines(text, fits):
    """The text as lines that ``fits(line)`` takes; a word that fits nowhere has a line of its own."""
    made = [""]
    for unit in _UNIT.findall(text):
        if unit.isspace():
            made[-1] += " " if made[-1] else ""
        elif not made[-1] or fits(made[-1] + unit):
            made[-1] += unit
        else:
            made[-1] = made[-1].rstrip()
            made.append(unit)
    made[-1] = made[-1].rstrip()
    return made
