"""Options of the mesh of an image, as properties of the operator that makes it."""

from ..core.options import option
from .options import option_property

LABELS = {
    "edge": {"label": "Edge Length", "high": 1000.0, "soft_high": 50.0},
    "threshold": {"label": "Threshold", "low": 0.001},
    "tolerance": {"label": "Tolerance", "high": 100.0, "soft_high": 5.0},
    "smallest": {"label": "Smallest", "high": 1e6, "soft_high": 100.0},
}


class ImageSettings:
    """Mixin: the options of lissom.image_mesh."""

    __annotations__ = {
        name: option_property(option("image_mesh", name, **label)) for name, label in LABELS.items()
    }


classes = ()
