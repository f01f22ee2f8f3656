"""What operators that tick shape keys share."""

from bpy.props import EnumProperty, StringProperty

from ..core.ticks import ACTIONS, ticked
from ..properties.ticks import put


class TickProperties:
    """Mixin: which ticks to set."""

    action: EnumProperty(name="Action", description="Which ticks to set", items=ACTIONS)
    key: StringProperty(name="Key", description="Name of the shape key to toggle", options={"SKIP_SAVE"})

    def tick(self, rows, known):
        """Sets them on a collection of ticks, of the ``known`` names."""
        put(rows, ticked(known, rows.keys(), self.action, self.key))
