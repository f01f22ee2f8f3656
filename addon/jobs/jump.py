"""Views that jump along with the landmark that is asked for: each shows where it is to be expected."""

from ..bridge import expected, views
from ..bridge.markers import SIDES

OBLIQUE = 0.7  # cosine: a view that looks at a place less from the front is turned


class Jumps:
    """Follows the prompts of one round of picking; ``views`` that it moved go back when it is left."""

    def __init__(self):
        self._prompt, self._before, self._left = None, {}, {}

    def follow(self, context, picked, two, area):
        """Has views show where the landmark of a core.picking.Picking is expected, once for each prompt.

        ``two`` are the addresses of the views of target and source, where there are these; else the view at
        the address ``area`` shows the side that is asked for next, the source where both are.
        """
        prompt = picked.wanted, not two and picked.side
        if not picked.wanted or prompt == self._prompt:
            return
        self._prompt = prompt
        found = expected.spots(context.scene, context.evaluated_depsgraph_get(), picked.wanted)
        if two:
            moves = dict(zip(SIDES[::-1], two, strict=True))
        else:
            sides = [side for side in SIDES if side != picked.side and side in found]
            moves = dict.fromkeys(sides[:1], area)
        for side, address in moves.items():
            if side in found and side != picked.side:
                self._show(address, found[side])

    def _show(self, address, spot):
        found = views.of_address(address)
        if found is None or found[1].spaces.active.region_3d.view_perspective == "CAMERA":
            return
        self._before = views.looks([address]) | self._before
        towards = views.direction(found[1])
        views.look_at(found[1], spot.corners, -spot.outward if towards @ -spot.outward < OBLIQUE else None)
        self._left |= views.looks([address])

    def back(self):
        """Views look as they did before, but those that the artist has moved since the last jump."""
        now = views.looks(self._left)
        same = [address for address, look in now.items() if views.same(look, self._left[address])]
        views.look_again({address: self._before[address] for address in same})
