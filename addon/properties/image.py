"""Options of the mesh of an image, as properties of the operator that makes it."""

from ..core.image import LABELS
from ..core.options import option
from .options import option_property


class ImageSettings:
    """Mixin: the options of lissom.image_mesh."""

    __annotations__ = {
        name: option_property(option("image_mesh", name, **label)) for name, label in LABELS.items()
    }


classes = ()
