"""Marker pairs and curves."""

from typing import NamedTuple

from .refused import Refused, first
from .surface import Point


class Marker(NamedTuple):
    """One pair: a label and a point of either mesh, by the vertex it is at, or nearest to, and a Point.

    A Point is None at the vertex itself. The places are those of the points at rest, in the objects' own
    coordinates, or None where unknown; ``mirror`` says whether symmetry may complete the pair; ``number``
    is the one that it keeps whatever becomes of the others, 0 where it has none yet. A ``guessed`` pair lies
    where a fit has it, and tells a fit nothing until it is moved or confirmed.
    """

    name: str
    source: int
    target: int
    source_place: tuple | None = None
    target_place: tuple | None = None
    mirror: bool = True
    source_point: Point | None = None
    target_point: Point | None = None
    number: int = 0
    guessed: bool = False

    @classmethod
    def between(cls, name, source, target):
        """The pair of two points."""
        return cls(name, -1, -1).on("source", source).on("target", target)

    def on(self, side, point):
        """The same pair at another point of "source" or "target"."""
        return self._replace(
            **{side: point.vertex, f"{side}_point": None if point.is_vertex else point, f"{side}_place": None}
        )

    def point(self, side):
        """That of "source" or "target"."""
        point = self.source_point if side == "source" else self.target_point
        return point or Point.at(self.source if side == "source" else self.target)

    @property
    def ends(self):
        """Its points on (source, target): what tells a pair from others."""
        return self.point("source"), self.point("target")

    def place(self, side):
        """That of "source" or "target"."""
        return self.source_place if side == "source" else self.target_place


class Curve(NamedTuple):
    """A path along edges of either mesh, by its vertices; a loop ends with its first.

    Its places are those of the vertices at rest, in the objects' own coordinates, or None where unknown.
    """

    name: str
    source: tuple
    target: tuple
    source_places: tuple | None = None
    target_places: tuple | None = None

    @property
    def vertices(self):
        """(source, target)."""
        return self.source, self.target

    @property
    def texts(self):
        """The same, with spaces between the vertices."""
        return tuple(" ".join(map(str, side)) for side in self.vertices)


def check_curves(curves, source_vertices, target_vertices):
    """Refused where an index is out of range or two curves are the same on a mesh (rows 9 and 28)."""
    for side, count in (("source", source_vertices), ("target", target_vertices)):
        beyond = [curve for curve in curves if not 0 <= max(getattr(curve, side)) < count]
        if beyond:
            raise Refused(
                f"The {side} mesh has {count} vertices, which these curves go beyond: "
                f"{first(repr(curve.name) for curve in beyond)}. "
                "Are source and target the meshes the curves were made for?"
            )
        seen = {}
        for curve in curves:
            other = seen.setdefault(frozenset(getattr(curve, side)), curve)
            if other is not curve:
                raise Refused(
                    f"Curves '{other.name}' and '{curve.name}' are the same on the {side}: remove one of them"
                )


def check(pairs, source_vertices, target_vertices):
    """Refused where an index is out of range or two pairs share a point (rows 9 and 28)."""
    for side, count in (("source", source_vertices), ("target", target_vertices)):
        beyond = [marker for marker in pairs if not 0 <= max(marker.point(side).corners) < count]
        if beyond:
            listed = first(f"'{marker.name}' at {getattr(marker, side)}" for marker in beyond)
            raise Refused(
                f"The {side} mesh has {count} vertices, which these markers lie beyond: {listed}. "
                "Are source and target the meshes the markers were made for?"
            )
        seen = {}
        for marker in pairs:
            point = marker.point(side)
            other = seen.setdefault(point, marker)
            if other is not marker:
                where = f"{side} vertex {point.vertex}" if point.is_vertex else f"point of the {side}"
                raise Refused(
                    f"Markers '{other.name}' and '{marker.name}' lie on the same {where}: remove one of them"
                )


def numbered(pairs):
    """The pairs, each with a number of its own: those without one get the next that no pair has."""
    free = max((marker.number for marker in pairs), default=0) + 1
    taken, found = set(), []
    for marker in pairs:
        if marker.number < 1 or marker.number in taken:
            marker, free = marker._replace(number=free), free + 1
        taken.add(marker.number)
        found.append(marker)
    return found


def new_name(pairs):
    """That of the next pair: its number, unless it is taken."""
    taken = {marker.name for marker in pairs}
    number = max((marker.number for marker in numbered(pairs)), default=0) + 1
    while f"Marker {number}" in taken:
        number += 1
    return f"Marker {number}"
