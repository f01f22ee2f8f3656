"""The file of marker pairs and curves.

A marker says that a point of one mesh, ``source``, and one of another, ``target``, are the same place. The
file is JSON::

    {"format": "lissom-markers", "version": 1,
     "source": {"name": "Face", "vertices": 26719}, "target": {"name": "Suzanne", "vertices": 507},
     "pairs": [{"name": "tip of the nose", "source": 1834, "target": 92,
                "target_point": [[92, 93, 81], [0.6, 0.3, 0.1]], "number": 1,
                "source_place": [0.0, -1.2, 0.3], "target_place": [0.0, -0.9, 0.1]}]}

``source`` and ``target`` of the whole are notes for the reader; only ``vertices`` is compared on loading.
Those of a pair are vertices. Where a point is not at one, ``source_point`` and ``target_point`` have three
vertices of its face and what each counts, and the vertex is the one that counts most. The places, in the
objects' own coordinates, may be missing; where the count of vertices has changed, markers are found again by
them. ``number`` is the one that the pair is known by. ``"mirror": false`` says that it has no counterpart on
the other side.

Curves, paths along edges of both meshes that belong together, follow where there are any::

     "curves": [{"name": "left lid", "source": [4, 5, 9, 4], "target": [7, 2, 3, 7],
                 "source_places": [[0.0, -1.2, 0.3], ...], "target_places": [...]}]

One that ends with its first vertex is a loop.

Lists as published transfer codes have them are read too: a pair of vertices a line, counted from 0, with a
comma, a colon or a space between, as in ``1834, 92``; a .cons file has their number in a line before them.
"""

import json
import os
import re
from typing import NamedTuple

from .files import replacing
from .markers import Curve, Marker
from .names import MAX_BYTES
from .refused import Refused
from .surface import Point

FORMAT = "lissom-markers"
VERSION = 1

# Far above any real file (a thousand pairs take 80 kB), far below what could stall Blender (row 41).
MAX_FILE_BYTES = 4 * 1024 * 1024
MAX_DEPTH = 16
MAX_PAIRS = 20_000
MAX_CURVES = 1000

_LINE_OF_LIST = re.compile(r"(\d{1,10})(?:\s*[,:\s]\s*(\d{1,10}))?$")
_STRING_OR_BRACKET = re.compile(r'"(?:[^"\\]|\\.)*+(?:"|\Z|\\)|[\[\]{}]', re.DOTALL)


class MarkerFile(NamedTuple):
    """What a file holds; a count of vertices is None where the file does not say."""

    pairs: list[Marker]
    source_vertices: int | None
    target_vertices: int | None
    curves: list[Curve] = []


def save(path, pairs, source, target, curves=()):
    """Writes them to ``path``; ``source`` and ``target`` are (name, vertex count) of the two meshes."""
    text = dumps(pairs, source, target, curves)
    with replacing(path, "w", encoding="utf-8") as file:
        file.write(text)


def load(path):
    """Reads a marker file; Refused where it is missing, too large, too deep or malformed."""
    if not os.path.isfile(path):  # a pipe or a device would block
        raise Refused(f"Marker file '{path}' does not exist")
    try:
        with open(path, "rb") as file:
            data = file.read(MAX_FILE_BYTES + 1)
    except OSError as error:
        raise Refused(f"Marker file '{path}' cannot be read: {error.strerror}") from error
    if len(data) > MAX_FILE_BYTES:
        raise Refused(
            f"Marker file '{path}' is larger than {MAX_FILE_BYTES // 2**20} MiB: this is no marker file"
        )
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise Refused(f"Marker file '{path}' is not text: byte {error.start} is not UTF-8") from error
    try:
        return loads(text)
    except Refused as error:
        raise Refused(f"Marker file '{path}': {error}") from error


def dumps(pairs, source, target, curves=()):
    """The text of a marker file, one pair or curve a line."""
    head = {
        "format": FORMAT,
        "version": VERSION,
        "source": {"name": source[0], "vertices": source[1]},
        "target": {"name": target[0], "vertices": target[1]},
    }
    parts = {"pairs": list(map(_row, pairs))} | ({"curves": list(map(_known, curves))} if curves else {})
    body = "".join(f',\n "{name}": {_listing(rows)}' for name, rows in parts.items())
    return json.dumps(head, ensure_ascii=False, indent=1)[:-2] + f"{body}\n}}\n"


def loads(text):
    """Reads the text of a marker file."""
    if len(text) > MAX_FILE_BYTES:
        raise Refused(f"more than {MAX_FILE_BYTES // 2**20} MiB of text")
    if text.lstrip()[:1].isdigit() or text.lstrip().startswith("#"):
        return MarkerFile(_listed(text), None, None)
    _check_depth(text)
    try:
        document = json.loads(text, parse_constant=_no_constant)
    except (ValueError, RecursionError) as error:
        raise Refused(f"not valid JSON: {error}") from error
    if not isinstance(document, dict) or document.get("format") != FORMAT:
        raise Refused(f'no lissom markers: "format" must be "{FORMAT}"')
    version = document.get("version")
    if not _is_index(version) or version != VERSION:
        raise Refused(f'"version" is {version!r:.40}, this release reads {VERSION}: update Lissom')
    found = []
    for name, most, read in (("pairs", MAX_PAIRS, _pair), ("curves", MAX_CURVES, _curve)):
        rows = document.get(name, [] if name == "curves" else None)
        if not isinstance(rows, list):
            raise Refused(f'"{name}" must be a list')
        if len(rows) > most:
            raise Refused(f'"{name}" holds {len(rows)} entries, more than {most}')
        found.append([read(number, row) for number, row in enumerate(rows)])
    pairs, curves = found
    return MarkerFile(pairs, _vertices(document, "source"), _vertices(document, "target"), curves)


def _listing(rows):
    lines = ",\n".join("  " + json.dumps(row, ensure_ascii=False) for row in rows)
    return f"[\n{lines}\n ]" if rows else "[]"


def _known(entry):
    return {name: value for name, value in entry._asdict().items() if value is not None}


def _row(marker):
    row = _known(marker)
    del row["guessed"]
    if marker.mirror:
        del row["mirror"]
    if not marker.number:
        del row["number"]
    return row


def _listed(text):
    pairs, promised = [], None
    for number, line in enumerate(text.splitlines(), start=1):
        line = line.split("#")[0].strip()
        if not line:
            continue
        match = _LINE_OF_LIST.match(line)
        alone = match is not None and match[2] is None
        if match is None or (alone and (pairs or promised is not None)):
            raise Refused(f"line {number} is no pair of vertices: {line!r:.40}")
        if alone:
            promised = int(match[1])
            continue
        source, target = int(match[1]), int(match[2])
        if not (_is_index(source) and _is_index(target)):
            raise Refused(f"line {number} is no pair of vertices: {line!r:.40}")
        pairs.append(Marker(f"Marker {len(pairs) + 1}", source, target))
        if len(pairs) > MAX_PAIRS:
            raise Refused(f"holds more than {MAX_PAIRS} pairs")
    if promised not in (None, len(pairs)):
        raise Refused(f"promises {promised} pairs and has {len(pairs)}")
    return pairs


def _check_depth(text):
    depth = 0
    for match in _STRING_OR_BRACKET.finditer(text):
        depth += {"[": 1, "{": 1, "]": -1, "}": -1}.get(match[0], 0)
        if depth > MAX_DEPTH:
            raise Refused(f"nested deeper than {MAX_DEPTH} levels")


def _no_constant(word):
    raise ValueError(f"{word} is not a number of JSON")


def _is_index(value):
    return isinstance(value, int) and not isinstance(value, bool) and 0 <= value < 2**31


def _is_place(value):
    return (
        isinstance(value, list)
        and len(value) == 3
        and all(isinstance(x, int | float) and not isinstance(x, bool) for x in value)
        and all(abs(x) < 1e30 for x in value)
    )


def _name(kind, number, row, default):
    name = row.get("name", default)
    if not isinstance(name, str):
        raise Refused(f'"{kind}" entry {number}: "name" must be text, not {name!r:.40}')
    return name.encode(errors="ignore")[:MAX_BYTES].decode(errors="ignore")


def _curve(number, row):
    if not isinstance(row, dict):
        raise Refused(f'"curves" entry {number} must be an object with "source" and "target"')
    found = {"name": _name("curves", number, row, f"Curve {number + 1}")}
    for side in ("source", "target"):
        vertices, places = row.get(side), row.get(f"{side}_places")
        if not isinstance(vertices, list) or len(vertices) < 2 or not all(map(_is_index, vertices)):
            raise Refused(
                f'"curves" entry {number}: "{side}" must be a list of two vertex indices or more, '
                f"not {vertices!r:.40}"
            )
        if places is not None:
            if (
                not isinstance(places, list)
                or len(places) != len(vertices)
                or not all(map(_is_place, places))
            ):
                raise Refused(
                    f'"curves" entry {number}: "{side}_places" must be three numbers for each vertex, '
                    f"not {places!r:.40}"
                )
            places = tuple(tuple(map(float, place)) for place in places)
        found |= {side: tuple(vertices), f"{side}_places": places}
    return Curve(**found)


def _pair(number, row):
    if not isinstance(row, dict):
        raise Refused(f'"pairs" entry {number} must be an object with "source" and "target"')
    for side in ("source", "target"):
        if not _is_index(row.get(side)):
            raise Refused(
                f'"pairs" entry {number}: "{side}" must be a vertex index, not {row.get(side)!r:.40}'
            )
    name = _name("pairs", number, row, f"Marker {number + 1}")
    places = [row.get(f"{side}_place") for side in ("source", "target")]
    for side, place in zip(("source", "target"), places, strict=True):
        if place is not None and not _is_place(place):
            raise Refused(f'"pairs" entry {number}: "{side}_place" must be three numbers, not {place!r:.40}')
    if not isinstance(row.get("mirror", True), bool):
        raise Refused(f'"pairs" entry {number}: "mirror" must be true or false, not {row["mirror"]!r:.40}')
    marker = Marker(name, row["source"], row["target"], mirror=row.get("mirror", True))
    if not _is_index(row.get("number", 0)):
        raise Refused(f'"pairs" entry {number}: "number" must be a whole number, not {row["number"]!r:.40}')
    for side, place in zip(("source", "target"), places, strict=True):
        if row.get(f"{side}_point") is not None:
            marker = marker.on(side, _point(number, f"{side}_point", row[f"{side}_point"]))
        if place is not None:
            marker = marker._replace(**{f"{side}_place": tuple(map(float, place))})
    return marker._replace(number=row.get("number", 0))


def _point(number, name, value):
    lists = isinstance(value, list) and len(value) == 2 and all(isinstance(part, list) for part in value)
    corners, weights = value if lists else ([], [])
    right = len(corners) == 3 and all(map(_is_index, corners)) and _is_place(weights)
    if not right or min(weights) < 0 or abs(sum(weights) - 1) > 1e-3:
        raise Refused(
            f'"pairs" entry {number}: "{name}" must be three vertices and what each counts, 1 together, '
            f"not {value!r:.40}"
        )
    return Point.of(corners, weights)


def _vertices(document, side):
    note = document.get(side)
    count = note.get("vertices") if isinstance(note, dict) else None
    return count if _is_index(count) else None
