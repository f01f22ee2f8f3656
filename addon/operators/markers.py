"""What operators on the list of marker pairs and curves share: whether there is one that they can act on."""

from .job import allowed


def needs_pair(operator_class, context):
    """poll(): source and target are chosen."""
    settings = context.scene.lissom_transfer
    missing = settings.source is None or settings.target is None or settings.source == settings.target
    return allowed(
        operator_class, "Choose two different objects as source and target first" if missing else ""
    )


def needs_markers(operator_class, context, or_curves=False):
    """poll(): there is something in the list."""
    settings = context.scene.lissom_transfer
    there = len(settings.markers) or (or_curves and len(settings.curves))
    return allowed(operator_class, "" if there else "There are no markers yet")
