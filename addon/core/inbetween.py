"""In-betweens of two shapes: what is asked for, and the path sampled at knots."""

from dataclasses import dataclass, field
from itertools import pairwise

import lissom
import numpy as np

from . import hat, mirrors
from .asked import Asked
from .refused import Refused

MAX_COUNT = 100  # in-betweens
# A file stores the place in this list: only append.
PLAYBACK_ITEMS = [
    ("RELATIVE", "Relative Keys", "The slider drives the baked keys; other keys add to them", 0),
    (
        "ABSOLUTE",
        "Absolute Keys",
        "The slider drives the evaluation time of absolute shape keys; other keys do not play meanwhile",
        1,
    ),
]
OPTIONS = ("rotation", "stretch", "refinement", "preserve_volume")


@dataclass
class ArcAsked(Asked):
    """Everything that the artist chooses about an arc."""

    object: str = ""  # its name; "" is the active one
    start: str = ""  # shape keys; "" is the reference key
    end: str = ""
    slider: str = ""
    exists: str = "UPDATE"
    sampling: str = "COUNT"
    count: int = 5
    tolerance: float = 0.001  # in scene units
    rotation: str = "consistent"
    stretch: str = "linear"
    refinement: int = 0
    preserve_volume: bool = False
    through: str = ""  # as stops() reads it
    clearance: str = ""  # a mesh object
    easing: str = "LINEAR"
    playback: str = "RELATIVE"
    reroute: bool = True
    prepare_keys: bool = True

    @property
    def options(self):
        """Those of lissom.Inbetween but the obstacle."""
        return {name: getattr(self, name) for name in OPTIONS}

    def start_knots(self, path):
        """A job that finds the times of the keys of a lissom.Inbetween; None where they are known."""
        if self.sampling == "PLACED":
            return path.start_keyframes(count=self.count + 2)
        return path.start_keyframes(self.tolerance, MAX_COUNT + 2) if self.sampling == "TOLERANCE" else None


def stops(text):
    """[(name, time)] in rising order of "key: time, key: time", what an arc goes through on its way."""
    found = []
    for part in filter(None, (part.strip() for part in text.split(","))):
        name, colon, time = part.rpartition(":")
        try:
            time = float(time)
        except ValueError:
            colon = ""
        if not (colon and name.strip() and hat.NEAREST < time < 1 - hat.NEAREST):
            raise Refused(f"Through: '{part}' is not a shape key and a time between 0 and 1, as 'half: 0.5'")
        found.append((name.strip(), time))
    found.sort(key=lambda stop: stop[1])
    again = [name for (name, time), (_, other) in pairwise(found) if other - time <= hat.NEAREST]
    if again:
        raise Refused(f"Through: '{again[0]}' and another key have the same time")
    return found


@dataclass
class Sampled:
    """A path at its knots."""

    knots: np.ndarray  # (k,)
    shapes: np.ndarray = field(repr=False)  # (k, n, 3)
    warnings: list


def path_steps(mesh, start, end, asked, obstacle=None, through=(), mirrors=mirrors.NONE):
    """Steps of a Work whose result is Sampled; ``mesh``: vertices, triangles; ``start`` and ``end``: (n, 3).

    ``through``: [(time, (n, 3))]. ``obstacle``: what the path keeps out of, as vertices at the start,
    triangles, vertices at the end. ``mirrors``: those of the object.
    """

    options = asked.options | {"through": list(through)} | mirrors.half(start)
    if obstacle is not None:
        vertices, triangles, last = obstacle
        options |= {"clearance": lissom.Mesh(vertices, triangles)}
        if not np.array_equal(vertices, last):
            options |= {"clearance_end": last}
    path = yield lissom.start_inbetween(lissom.Mesh(*mesh), start, end, **options)
    knots, said, times = hat.uniform_knots(asked.count), [], [time for time, _ in through]
    search = asked.start_knots(path)
    if search is not None:
        found = yield search
        knots, said = found.times, list(found.warnings)
    wanted, knots = len(knots), hat.spread(knots, times)
    if search is not None and len(knots) < wanted:
        said.append("Keys closer to another than the slider tells apart are left out")
    shapes = yield path.start_at(knots)
    return Sampled(knots, shapes, [*path.warnings, *said])
