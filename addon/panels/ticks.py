"""Lists of shape keys with a tick each."""

import bpy


class TickList:
    """Mixin of UILists, which have ``tick``, the name of an operator, ``chosen`` and ``offered``."""

    def draw_item(self, context, layout, data, item, icon, active_data, active_property):
        ticked = item.name in self.chosen(context)
        row = layout.row(align=True)
        toggle = row.operator(
            self.tick, text="", icon="CHECKBOX_HLT" if ticked else "CHECKBOX_DEHLT", emboss=False
        )
        toggle.action, toggle.key = "TOGGLE", item.name
        row.label(text=item.name, translate=False)
        self.draw_more(context, row, item, toggle)

    def draw_more(self, context, row, item, toggle):
        """What else the row has; ``toggle`` is the button of the tick."""

    def filter_items(self, context, data, property_name):
        keys = getattr(data, property_name)
        flags = [self.bitflag_filter_item] * len(keys)
        if self.filter_name:
            flags = bpy.types.UI_UL_list.filter_items_by_name(
                self.filter_name, self.bitflag_filter_item, keys
            )
        offered = set(self.offered(context))
        return [flag if key.name in offered else 0 for flag, key in zip(flags, keys, strict=True)], []


def draw_ticks(layout, lister, obj, tick, rows):
    """The list of an object's shape keys, and the buttons for all and none; these buttons."""
    column = layout.column(align=True)
    keys = obj.data.shape_keys
    column.template_list(lister, "", keys, "key_blocks", obj, "active_shape_key_index", rows=rows)
    row, buttons = column.row(align=True), []
    for action in ("ALL", "NONE"):
        buttons.append(row.operator(tick, text=action.capitalize()))
        buttons[-1].action = action
    return buttons
