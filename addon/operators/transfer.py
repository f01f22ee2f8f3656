"""What operators of a transfer share: what they are made of, and what the panel still misses."""

from bpy.props import StringProperty

from ..bridge import checks
from ..bridge.assembly import both_sides
from ..core.refused import Refused
from ..jobs.fit import key_names
from ..properties.transfer_options import fit_properties, transfer_properties
from .job import allowed
from .objects import SOURCE, TARGET

MARKERS = {
    "name": "Markers",
    "description": "Marker pairs as the text of a marker file; empty: the scene's list, and where that is "
    "empty too, the shapes alone",
    "options": {"SKIP_SAVE"},
}
MARKER_FILE = {
    "name": "Marker File",
    "description": "Marker file to use in place of the scene's list",
    "subtype": "FILE_PATH",
    "options": {"SKIP_SAVE"},
}


class FitProperties:
    """Mixin: what a fit is made of; to stand before job.JobRunner."""

    keeps = "lissom_transfer"

    __annotations__ = {
        "source": StringProperty(**SOURCE),
        "target": StringProperty(**TARGET),
        "markers": StringProperty(**MARKERS),
        "filepath": StringProperty(**MARKER_FILE),
        **fit_properties(),
    }


class TransferProperties(FitProperties):
    """Mixin: what a transfer is made of."""

    __annotations__ = transfer_properties()


def ready(operator_class, context, keys=False, writes=False):
    """poll(): what the panel still misses, said on its buttons; scripts' calls are checked as they run."""
    settings = getattr(context, "lissom_transfer", None)
    reason = ""
    if settings is not None:
        try:
            sources, targets = both_sides(context, "", "")
        except Refused:
            return allowed(operator_class, "Choose two different objects as source and target first")
        if keys and not key_names(sources):
            reason = f"'{sources[0].name}' has no shape keys to carry over"
        elif keys and settings.which == "SELECTED" and not len(settings.chosen):
            reason = "Tick the shape keys to carry over first"
        elif keys or writes:
            reason = next(filter(None, map(checks.refusal, targets)), "")
    return allowed(operator_class, reason)
