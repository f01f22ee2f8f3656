"""Drawings: a flat mesh of what an image shows, and a second image at the end of its arc."""

from dataclasses import dataclass

import lissom

from ..bridge import arcs, images
from ..core.image import LABELS
from ..core.options import default
from ..core.refused import Refused
from ..core.work import Work
from . import Asked, Done
from .arcs import arc_object


@dataclass(kw_only=True)
class ImageAsked(Asked):
    """What a mesh of an image is made of."""

    image: str = ""  # name of an image in this file; "": the file
    filepath: str = ""
    height: float = 2.0  # of the whole image
    edge: float = default("image_mesh", "edge")
    threshold: float = default("image_mesh", "threshold")
    tolerance: float = default("image_mesh", "tolerance")
    smallest: float = default("image_mesh", "smallest")


@dataclass(kw_only=True)
class ImageDone(Done):
    """``object``: the name of the new mesh object."""

    object: str


class ImageMesh:
    """A flat mesh of what an image shows, to be posed by handles in its plane."""

    def __init__(self, context, asked):
        image = images.find(asked.image, asked.filepath)
        self._image, self._height = image.name, asked.height
        opacity, options = images.alpha(image), {name: getattr(asked, name) for name in LABELS}

        def steps():
            return (yield lissom.start_image_mesh(opacity, **options))

        self.work = Work(steps())

    def write(self, context, made):
        """Makes an object of what lissom.image_mesh has found; an ImageDone."""
        obj = images.make(images.find(self._image), made, self._height)
        told = f"'{obj.name}': {len(made.vertices)} vertices, {len(made.triangles)} triangles"
        return ImageDone(summary=told, warnings=list(made.warnings), object=obj.name)


def lay_second(context, name="", slider="", image="", filepath=""):
    """Lays a second image under the end of an arc of an object, by default the last one; an ImageDone."""
    obj = arc_object(context, name)
    baked = obj.lissom_inbetween.arcs
    if not slider and not len(baked):
        raise Refused("Bake the arc to the key that the second image shows first")
    arc = arcs.find(obj, slider or baked[-1].name)
    warnings = images.lay(obj, images.find(image, filepath), arc)
    return ImageDone(
        summary=f"'{arc.name}' dissolves to the second image", warnings=list(warnings), object=obj.name
    )
