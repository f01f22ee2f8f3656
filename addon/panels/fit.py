"""The last fit: how good it is, and what is wrong with it."""

from .. import session
from ..bridge import colours
from ..core.colours import LEGEND, LIMIT
from ..core.transfer_options import MASKS, OPTIONS
from .common import BUTTON, draw_lines, side_by_side

FIT_OPTIONS = (*OPTIONS["fit"], *MASKS)


def fit_of(settings):
    """The last fit, where it is one of the objects that are chosen; else None."""
    memory = session.fit
    if memory is None or not settings.source or not settings.target:
        return None
    same = (memory.source.name, memory.target.name) == (settings.source.name, settings.target.name)
    return memory if same else None


def doubts(settings):
    """{ends: (marker, why)} of the markers that the last fit doubts."""
    memory = fit_of(settings)
    return memory.doubts if memory else {}


def draw_fit(layout, context):
    """How good the last fit is, and what is wrong with it."""
    settings = context.scene.lissom_transfer
    memory = fit_of(settings)
    if memory is None:
        return
    markers = [row.ends for row in settings.markers if not row.guessed]
    listed = ([], []) if settings.overlap else (markers, [row.vertices for row in settings.curves])
    current = (memory.pairs, memory.curves) == listed
    grave = any(fault.grave for fault in memory.faults)
    for place, fault in enumerate(memory.faults):
        _draw_fault(layout, place, fault, current)
    if not current:
        draw_lines(layout, "INFO", "The markers were changed since the last fit: Transfer fits again")
    draw_lines(layout, "CHECKMARK" if current and not grave else "NONE", memory.summary)
    row = side_by_side(layout, "Show Fit", "Suggest Marker")
    shown = any(map(colours.shown, filter(None, (settings.source, settings.target))))
    row.operator(
        "lissom.fit_show", text="Hide Fit" if shown else "Show Fit", icon="COLOR", depress=shown
    ).show = not shown
    if not settings.overlap:
        row.operator("lissom.marker_suggest", icon="OUTLINER_OB_LIGHT")
    if shown:
        draw_lines(layout, "NONE", LEGEND.format(limit=100 * LIMIT))


def _draw_fault(layout, place, fault, current):
    """One line of what is wrong, red until it is mended, and a button that shows where."""
    row = layout.row()
    told = row.column()
    told.alert = fault.grave
    draw_lines(told, "ERROR" if fault.grave else "INFO", fault.line, margin=BUTTON)
    if current:
        row.operator("lissom.fit_place", text="", icon="ZOOM_SELECTED").place = place
