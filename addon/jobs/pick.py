"""Picking: the halves of pairs as they come in, and the landmarks that are asked for in turn."""

from .. import session
from ..bridge import landmarks
from ..bridge import markers as bridge_markers
from ..bridge.markers import SIDES
from ..core import markers
from ..core.landmarks import upcoming
from ..core.picking import Picking
from ..core.refused import Refused


def begin(context):
    """Puts the scene's markers where they are now and starts session.picking; returns warnings."""
    ends = bridge_markers.pair_of_objects(context, "", "")
    for obj in ends:
        if obj.mode != "OBJECT":
            raise Refused(f"'{obj.name}' is in {obj.mode.lower()} mode: go to Object Mode first")
        if obj.hide_get() or obj.hide_viewport:  # a view may show one of them alone
            raise Refused(f"'{obj.name}' is hidden: show it first")
    known, warnings = bridge_markers.current(context.scene, *ends)
    markers.check(known, *(len(obj.data.vertices) for obj in ends))
    bridge_markers.put(context.scene, known, *ends)
    context.scene.lissom_transfer.show_markers = True
    session.picking = Picking()
    return warnings


class Picks:
    """What clicks do to the scene's markers; ``done`` is told of each step that can be undone."""

    def __init__(self, done):
        self._done, self._asked = done, None

    def ask(self, scene):
        """Asks for the next landmark, and takes the half of it that a mesh bears already."""
        settings, picked = scene.lissom_transfer, session.picking
        state = settings.landmarks, tuple(row.name for row in settings.markers), len(picked.skipped)
        if state == self._asked:
            return
        names, marked = landmarks.names(settings), {row.name for row in settings.markers}
        picked.drop()
        picked.wanted = upcoming(names, marked, picked.skipped) or ""
        self._asked = state
        borne = {side: landmarks.of(getattr(settings, side)).get(picked.wanted) for side in SIDES}
        try:
            for side, point in borne.items():
                if point is not None:
                    self.take(scene, side, point)
        except Refused:  # another marker is there
            self.skip(scene)

    def skip(self, scene):
        """Leaves the landmark that is asked for out."""
        session.picking.skipped.add(session.picking.wanted)
        self.ask(scene)

    def asked(self, scene):
        """What is asked for, or "" where any place will do."""
        names, picked = landmarks.names(scene.lissom_transfer), session.picking
        if picked.wanted not in names:
            return ""
        where = {"source": "on the target", "target": "on the source"}.get(picked.side, "on either mesh")
        return f"{names.index(picked.wanted) + 1} of {len(names)}: {picked.wanted}, {where}"

    def take(self, scene, side, point):
        """Takes a point as half of a pair; with the other half it becomes a marker."""
        for marker in bridge_markers.of_scene(scene):
            if marker.point(side) == point:
                raise Refused(f"This place of the {side} bears marker '{marker.name}' already")
        pair = session.picking.take(side, point)
        if pair:
            settings = scene.lissom_transfer
            new = markers.Marker.between(session.picking.wanted, *map(pair.get, SIDES))
            bridge_markers.append(scene, [new], settings.source, settings.target)
            self._done("Pick Marker Pair")
            self.ask(scene)

    def remove(self, scene, index):
        """Removes a pair, or by -1 the half that is begun."""
        if index < 0:
            session.picking.drop()
            return
        bridge_markers.remove(scene, index)
        self._done("Remove Marker Pair")

    def move(self, scene, index, side, point):
        """Moves a mark while it is dragged; by -1 that of the half."""
        if index < 0:
            session.picking.take(side, point)
        else:
            bridge_markers.move(scene, index, side, point)

    def moved(self, scene, index, side, before):
        """The mark that was at ``before`` is let go."""
        if index >= 0:
            scene.lissom_transfer.active_marker = index
            if scene.lissom_transfer.markers[index].point(side) != before:
                self._done("Move Marker")
