"""Blinks that go round the eyeballs: a key goes straight, and through a tall eye."""

import re
from dataclasses import dataclass

import numpy as np

from ..bridge import checks, shape_keys
from ..bridge.assembly import Assembly
from ..bridge.kept import offsets
from ..core.inbetween import ArcAsked
from ..core.refused import Refused
from . import Asked
from .bake import BakeAll

BLINKS = re.compile(r"(eyeBlink|blink)(Left|Right|_L|_R)")  # in the sets of names: of one eye each
KEYS = 8  # between two of so many the eye does not show through


@dataclass(kw_only=True)
class BlinksAsked(Asked):
    """The head by name, and the objects that are its eyeballs, one a line."""

    target: str = ""
    eyes: str = ""


class Blinks(BakeAll):
    """The arcs to the keys of a head that close one eye, clear of the eyeball nearest to what these move."""

    def __init__(self, context, asked):
        head = checks.mesh_object(asked.target, context)
        eyes = [checks.mesh_object(name, context) for name in asked.eyes.splitlines() if name]
        if not eyes:
            raise Refused("Add the eyeballs as objects of the target first: what lids go round")
        keys = [name for name in shape_keys.key_names(head) if BLINKS.fullmatch(name)]
        if not keys:
            raise Refused(f"'{head.name}' has no blinks of Face Keys: press Face Keys first")
        side, wanted = Assembly([head, *eyes]), []
        rest, *balls = side.split(side.rest())
        for name in keys:
            moved = np.linalg.norm(offsets(head.data.shape_keys.key_blocks[name]), axis=1)
            middle = np.average(rest, axis=0, weights=moved) if moved.any() else rest.mean(axis=0)
            away = [np.linalg.norm(ball - middle, axis=1).min() for ball in balls]
            nearest = int(np.argmin(away))
            eye = eyes[nearest]
            if away[nearest] > np.ptp(balls[nearest], axis=0).max() / 2:
                raise Refused(f"No eyeball is beside what '{name}' moves: give those of both eyes")
            wanted.append(ArcAsked(object=head.name, end=name, clearance=eye.name, count=KEYS))
        super().__init__(context, wanted)
