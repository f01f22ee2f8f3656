"""Marker pairs, curves and landmarks."""

import bpy
from bpy.props import (
    BoolProperty,
    CollectionProperty,
    FloatVectorProperty,
    IntProperty,
    IntVectorProperty,
    StringProperty,
)

from ..bridge.meshes import rest_place
from ..bridge.screen import redraw_views
from ..core.surface import Point


def _at_vertex(side):
    """Puts a mark on the vertex whose number was changed by hand."""

    def update(row, _):
        obj, vertex = getattr(row.id_data.lissom_transfer, side), getattr(row, side)
        row.put(side, Point.at(vertex), rest_place(obj.data, vertex) if obj else None)
        redraw_views()

    return update


class LissomMarker(bpy.types.PropertyGroup):
    """One marker pair, as core.markers.Marker has it; weights are 0 where a point is at its vertex.

    Its places, of the points at rest, survive edits of the meshes.
    """

    name: StringProperty(name="Name", description="What this place is, such as: left corner of the mouth")
    source: IntProperty(
        name="Source Vertex", min=0, update=_at_vertex("source"),
        description="The vertex of the source that the mark is at or nearest to; another one puts it there",
    )  # fmt: skip
    target: IntProperty(
        name="Target Vertex", min=0, update=_at_vertex("target"),
        description="The vertex of the target that the mark is at or nearest to; another one puts it there",
    )  # fmt: skip
    source_corners: IntVectorProperty(size=3)
    target_corners: IntVectorProperty(size=3)
    source_weights: FloatVectorProperty(size=3)
    target_weights: FloatVectorProperty(size=3)
    number: IntProperty(description="The one that the pair is known by; 0: not numbered yet")
    source_place: FloatVectorProperty(size=3)
    target_place: FloatVectorProperty(size=3)
    guessed: BoolProperty(
        name="Guessed",
        description="It lies where the fit has it, and tells the fit nothing until it is confirmed or moved",
    )
    source_placed: BoolProperty()
    target_placed: BoolProperty()
    mirror: BoolProperty(
        name="Symmetric",
        description="Complete this pair on the other side when Mirror is pressed",
        default=True,
    )

    def place(self, side):
        """(x, y, z) at rest on "source" or "target", in the object's coordinates, or None."""
        return tuple(getattr(self, f"{side}_place")) if getattr(self, f"{side}_placed") else None

    def point(self, side):
        """The Point on "source" or "target"."""
        weights = tuple(getattr(self, f"{side}_weights"))
        if not any(weights):
            return Point.at(getattr(self, side))
        return Point.of(getattr(self, f"{side}_corners"), weights)

    @property
    def ends(self):
        """Its points on (source, target)."""
        return self.point("source"), self.point("target")

    def put(self, side, point, place):
        """Keeps a point and its place, or that there is none."""
        if getattr(self, side) != point.vertex:
            setattr(self, side, point.vertex)
        setattr(self, f"{side}_corners", point.corners)
        setattr(self, f"{side}_weights", (0, 0, 0) if point.is_vertex else point.weights)
        setattr(self, f"{side}_placed", place is not None)
        if place is not None:
            setattr(self, f"{side}_place", place)

    def swap(self):
        """Exchanges its points on source and target."""
        (source, target), places = self.ends, (self.place("source"), self.place("target"))
        self.put("source", target, places[1])
        self.put("target", source, places[0])


class LissomLandmark(bpy.types.PropertyGroup):
    """A named point of a mesh object, and its place at rest in the object's coordinates."""

    name: StringProperty(name="Name")
    corners: IntVectorProperty(size=3)
    weights: FloatVectorProperty(size=3)
    place: FloatVectorProperty(size=3)


class LissomCurve(bpy.types.PropertyGroup):
    """One curve: paths along edges of both meshes by their vertices, and their places at rest as JSON."""

    name: StringProperty(name="Name", description="What this rim is, such as: upper lip")
    source: StringProperty(description="Vertices of the source, with spaces between")
    target: StringProperty(description="Vertices of the target, with spaces between")
    source_places: StringProperty()
    target_places: StringProperty()

    @property
    def vertices(self):
        """(source, target)."""
        return self.source, self.target


classes = (LissomMarker, LissomLandmark, LissomCurve)


def register():
    bpy.types.Object.lissom_landmarks = CollectionProperty(type=LissomLandmark)


def unregister():
    del bpy.types.Object.lissom_landmarks
