"""Source and target each in a view of its own, side by side, to pick in both at once."""

import bpy

from .. import session
from ..bridge import views
from ..bridge.assembly import both_sides
from .job import allowed, answering


class LISSOM_OT_marker_views(bpy.types.Operator):
    """Split the view in two, the source alone in the left one and the target alone in the right one, as long
    as this is on. Markers are picked in both"""

    bl_idname = "lissom.marker_views"
    bl_label = "Two Views"
    bl_options = {"REGISTER"}  # of the window, which undo leaves alone

    @classmethod
    def poll(cls, context):
        settings = context.scene.lissom_transfer
        missing = None in (settings.source, settings.target) or settings.source == settings.target
        return allowed(cls, "Choose two different objects as source and target first" if missing else "")

    @answering
    def execute(self, context):
        if session.views is not None:
            before, session.views = session.views, None
            views.together(context, before)
            return
        session.views = views.split(context, both_sides(context, "", ""))
        bpy.app.timers.register(_frame, first_interval=0.0)


def _frame():
    addresses = session.views or ()
    if not views.settled(addresses):
        return 0.02
    views.frame(addresses)
    return None


classes = (LISSOM_OT_marker_views,)
