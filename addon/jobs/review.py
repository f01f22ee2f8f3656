"""Review: transferred keys looked at one by one on both meshes, and nothing left changed afterwards."""

import bpy

from .. import session
from ..bridge import checks, pins, shape_keys, views
from ..core.quality import badness
from ..core.refused import Refused
from . import learn_shown
from .mend import ByHandles, remove


class Review:
    """The objects of source and target by name, and the key that they show now."""

    def __init__(self, context, sides):
        """``sides`` are the objects of the source and of the target."""
        for obj in (obj for side in sides for obj in side):
            if obj.mode != "OBJECT":
                raise Refused(f"'{obj.name}' is in {obj.mode.lower()} mode: go to Object Mode first")
        settings, layer = context.scene.lissom_transfer, context.view_layer
        self._sides = [[obj.name for obj in side] for side in sides]
        self._active = layer.objects.active and layer.objects.active.name
        self._selected = [obj.name for obj in context.selected_objects]
        self._row = settings.active_quality
        self._handles = None  # ByHandles while a key is mended by them
        self.key, self.on = "", True
        rows = order(settings)
        if not rows:
            raise Refused("Transfer with Check Quality first")
        for obj in (obj for side in sides for obj in side):  # the row that is chosen chooses a key
            pins.remember(obj)
        settings.active_quality = rows[0]
        self.show(settings)

    def _objects(self, side):
        return [obj for obj in map(bpy.data.objects.get, self._sides[side]) if obj is not None]

    def show(self, settings):
        """Shows the key of the active row on both sides, or where that is switched off the Basis."""
        if settings.active_quality >= len(settings.quality):
            return
        row = settings.quality[settings.active_quality]
        self.key = row.name
        for side, name in ((0, row.source or row.name), (1, row.name)):
            for obj in self._objects(side):
                keys = obj.data.shape_keys
                place = keys.key_blocks.find(name) if keys and self.on else 0
                pins.show(obj, max(place, 0))

    def step(self, settings, by):
        """Goes on to the row so many places further, as the list shows them."""
        rows = order(settings)
        if rows:
            place = rows.index(settings.active_quality) if settings.active_quality in rows else 0
            self.on = True
            settings.active_quality = rows[min(max(place + by, 0), len(rows) - 1)]
            self.show(settings)

    def toggle(self, settings):
        """Switches between the key and the Basis."""
        self.on = not self.on
        self.show(settings)

    @property
    def mending(self):
        """The object that a key is mended on: of the target in Sculpt Mode, or one to pose; or None."""
        posed = self._handles and self._handles.find()
        return posed or next((obj for obj in self._objects(1) if obj.mode != "OBJECT"), None)

    def mend(self, context, by="SCULPT", view=None):
        """Opens the shown key on the target, ``by`` "SCULPT" or "HANDLES".

        ``view`` is the address of the 3D view that shows the target alone, or None.
        """
        self.rest(context)
        self.on = True
        self.show(context.scene.lissom_transfer)
        found = [
            obj
            for obj in self._objects(1)
            if obj.data.shape_keys and self.key in obj.data.shape_keys.key_blocks
        ]
        if not found:
            raise Refused(f"The target has no shape key named '{self.key}' any more")
        obj = found[0]
        checks.require_writable(obj)
        key = shape_keys.find(obj, self.key)
        checks.require_unlocked([key])
        if by == "HANDLES":
            self._handles = ByHandles(context, obj, key, view)
            return
        for other in context.selected_objects:
            other.select_set(False)
        obj.select_set(True)
        context.view_layer.objects.active = obj
        bpy.ops.object.mode_set(mode="SCULPT")

    def rest(self, context):
        """Back from mending a key to looking at it."""
        handles, self._handles = self._handles, None
        if handles is not None:
            handles.keep(context)
        obj = self.mending
        if obj is not None:
            context.view_layer.objects.active = obj
            bpy.ops.object.mode_set(mode="OBJECT")
        self.show(context.scene.lissom_transfer)

    def lift(self):
        """Takes pins and mutes off, until ``show`` is called again.

        What is posed by handles is done: there is no other place for it than the key.
        """
        if self._handles is not None:
            self.rest(bpy.context)
        for obj in self._objects(0) + self._objects(1):
            pins.lift(obj)

    def fixes(self, obj):
        """Whether a key is mended on this object, which is a copy."""
        return self._handles is not None and self._handles.find() == obj

    def again(self, context):
        """Shows the key again after undo or redo, which know of no review."""
        if self._handles is not None and self._handles.find() is None:
            self._handles.give_back(context)
            self._handles = None
        settings = context.scene.lissom_transfer
        place = settings.quality.find(self.key)
        if place < 0:  # undone with the transfer that made it
            session.review = None
            return
        settings.active_quality = place
        made = self._handles and self._handles.find()
        views.show_again(session.views, [self._objects(0), [made] if made else self._objects(1)])
        self.show(settings)

    def leave(self, context):
        """Gives everything back as it was before, but for what was mended."""
        try:
            self.rest(context)
        finally:
            self._give_back(context)

    def _give_back(self, context):
        settings, layer = context.scene.lissom_transfer, context.view_layer
        settings.active_quality = self._row  # its key becomes the active one
        for obj in self._objects(0) + self._objects(1):
            pins.give_back(obj)
        for obj in layer.objects:
            obj.select_set(obj.name in self._selected)
        layer.objects.active = layer.objects.get(self._active) if self._active else None


def put_right(context):
    """After undo, redo and loading: a review that goes on is seen, of one that is over nothing is left."""
    review = session.review
    if review is not None:
        review.again(context)
        review = session.review
    for obj in list(bpy.data.objects):
        if obj.lissom_shown.mends and not (review and review.fixes(obj)):
            remove(obj)
        elif obj.lissom_shown.on and review is None and not learn_shown.shows(obj):
            learn_shown.take_away(obj)


def order(settings):
    """The places of the rows of the table in the order of the review: the worst first."""
    rows, by = settings.quality, settings.quality_order
    return sorted(range(len(rows)), key=lambda place: badness(rows[place], by), reverse=True)


def show_row(scene):
    """The key of the row that was clicked becomes the active one of the target, and is shown in a review."""
    settings = scene.lissom_transfer
    if session.review is not None:
        session.review.show(settings)
        return
    row = settings.quality[settings.active_quality]
    keys = settings.target.data.shape_keys if settings.target else None
    if keys and row.name in keys.key_blocks:
        settings.target.active_shape_key_index = keys.key_blocks.find(row.name)
