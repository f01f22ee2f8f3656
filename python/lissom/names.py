"""Names of facial shape keys, and of which others each set's are sums.

ARKit's are in Apple's order and spelling (``ARFaceAnchor.BlendShapeLocation``), from those of the ICT face;
VRM 1.0's preset expressions and the 15 visemes of Oculus's lip sync are combinations of ARKit's, by weights of
our own.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import ArrayLike, NDArray

    Weights = Mapping[str, float]

__all__ = ["ARKIT", "SETS", "VISEMES", "VRM", "combined"]

_SIDES = {"Left": "_L", "Right": "_R"}
_WHOLE = ("jawLeft", "jawRight", "mouthLeft", "mouthRight")  # go to a side, and have none
_SUMS = ("browInnerUp", "cheekPuff")  # of two sides that ARKit does not tell apart
_ORDER = [
    "eyeBlinkLeft", "eyeLookDownLeft", "eyeLookInLeft", "eyeLookOutLeft", "eyeLookUpLeft", "eyeSquintLeft",
    "eyeWideLeft", "eyeBlinkRight", "eyeLookDownRight", "eyeLookInRight", "eyeLookOutRight", "eyeLookUpRight",
    "eyeSquintRight", "eyeWideRight", "jawForward", "jawLeft", "jawRight", "jawOpen", "mouthClose",
    "mouthFunnel", "mouthPucker", "mouthLeft", "mouthRight", "mouthSmileLeft", "mouthSmileRight",
    "mouthFrownLeft", "mouthFrownRight", "mouthDimpleLeft", "mouthDimpleRight", "mouthStretchLeft",
    "mouthStretchRight", "mouthRollLower", "mouthRollUpper", "mouthShrugLower", "mouthShrugUpper",
    "mouthPressLeft", "mouthPressRight", "mouthLowerDownLeft", "mouthLowerDownRight", "mouthUpperUpLeft",
    "mouthUpperUpRight", "browDownLeft", "browDownRight", "browInnerUp", "browOuterUpLeft",
    "browOuterUpRight", "cheekPuff", "cheekSquintLeft", "cheekSquintRight", "noseSneerLeft", "noseSneerRight",
    "tongueOut",
]  # fmt: skip


def _of_ict(name: str) -> Weights:
    if name in _SUMS:
        return {f"{name}_L": 1.0, f"{name}_R": 1.0}
    side = next((side for side in _SIDES if name.endswith(side) and name not in _WHOLE), "")
    return {name.removesuffix(side) + _SIDES.get(side, ""): 1.0}


def _both(**weights: float) -> Weights:
    return {name + side: weight for name, weight in weights.items() for side in _SIDES}


ARKIT: Mapping[str, Weights] = {name: _of_ict(name) for name in _ORDER}
"""The 52, of the ICT face's names."""

VRM: Mapping[str, Weights] = {
    "happy": {**_both(mouthSmile=0.8, cheekSquint=0.5, eyeSquint=0.3), "browInnerUp": 0.2},
    "angry": _both(browDown=1.0, noseSneer=0.5, mouthFrown=0.4, mouthPress=0.4, eyeSquint=0.3),
    "sad": {"browInnerUp": 0.9, **_both(mouthFrown=0.7, eyeLookDown=0.2), "mouthShrugLower": 0.3},
    "relaxed": _both(mouthSmile=0.3, eyeBlink=0.3, eyeSquint=0.2),
    "surprised": {"browInnerUp": 0.8, **_both(browOuterUp=0.8, eyeWide=0.8), "jawOpen": 0.35},
    "aa": {"jawOpen": 0.6, **_both(mouthLowerDown=0.2, mouthUpperUp=0.1)},
    "ih": {"jawOpen": 0.2, **_both(mouthStretch=0.4, mouthLowerDown=0.3, mouthUpperUp=0.2)},
    "ou": {"jawOpen": 0.15, "mouthPucker": 0.7, "mouthFunnel": 0.3},
    "ee": {"jawOpen": 0.15, **_both(mouthSmile=0.4, mouthStretch=0.3, mouthLowerDown=0.3)},
    "oh": {"jawOpen": 0.4, "mouthFunnel": 0.6, "mouthPucker": 0.2},
    "blink": _both(eyeBlink=1.0),
    "blinkLeft": {"eyeBlinkLeft": 1.0},
    "blinkRight": {"eyeBlinkRight": 1.0},
    "lookUp": _both(eyeLookUp=1.0),
    "lookDown": _both(eyeLookDown=1.0),
    "lookLeft": {"eyeLookOutLeft": 1.0, "eyeLookInRight": 1.0},
    "lookRight": {"eyeLookInLeft": 1.0, "eyeLookOutRight": 1.0},
}
"""VRM 1.0's preset expressions but ``neutral``, of ARKit's names."""

VISEMES: Mapping[str, Weights] = {
    "viseme_sil": {},
    "viseme_PP": {"mouthRollLower": 0.3, "mouthRollUpper": 0.3, **_both(mouthPress=0.6)},
    "viseme_FF": {"jawOpen": 0.1, "mouthRollLower": 0.5, **_both(mouthUpperUp=0.4, mouthLowerDown=0.1)},
    "viseme_TH": {"jawOpen": 0.2, **_both(mouthUpperUp=0.2, mouthLowerDown=0.3)},
    "viseme_DD": {"jawOpen": 0.15, **_both(mouthUpperUp=0.2, mouthLowerDown=0.4)},
    "viseme_kk": {"jawOpen": 0.25, **_both(mouthUpperUp=0.2, mouthStretch=0.2)},
    "viseme_CH": {"jawOpen": 0.1, "mouthFunnel": 0.6, "mouthPucker": 0.2},
    "viseme_SS": {"jawOpen": 0.05, **_both(mouthStretch=0.4, mouthLowerDown=0.4, mouthUpperUp=0.2)},
    "viseme_nn": {"jawOpen": 0.15, **_both(mouthLowerDown=0.3, mouthUpperUp=0.1)},
    "viseme_RR": {"jawOpen": 0.15, "mouthFunnel": 0.4, "mouthPucker": 0.1},
    "viseme_aa": VRM["aa"],
    "viseme_E": {"jawOpen": 0.3, **_both(mouthStretch=0.3, mouthLowerDown=0.3, mouthSmile=0.2)},
    "viseme_ih": VRM["ih"],
    "viseme_oh": VRM["oh"],
    "viseme_ou": VRM["ou"],
}
"""Oculus's visemes in its order, of ARKit's names."""

SETS: Mapping[str, Mapping[str, Weights]] = {"ARKIT": ARKIT, "VRM": VRM, "VISEMES": VISEMES}


def combined(
    wanted: str | Mapping[str, Weights], names: Sequence[str], offsets: ArrayLike
) -> tuple[list[str], NDArray[np.float64], dict[str, list[str]]]:
    """The keys of a set as sums of others.

    wanted: one of ``SETS``, or such a table.
    names: those of the k ``offsets`` (k, n, 3), displacements from rest: ICT's or ARKit's.

    Returns the names of the m keys that can be made, in the set's order; their offsets (m, n, 3); and of each
    that cannot be made what it lacks, as ARKit's ``tongueOut`` does without a tongue's key.

    Raises KeyError for an unknown set, ValueError for another number of names or a name that comes twice.
    """
    given = np.asarray(offsets, dtype=np.float64)
    if given.ndim != 3 or len(given) != len(names):
        raise ValueError(f"offsets: shape {given.shape} with {len(names)} names: (k, n, 3) for k names")
    place = {name: i for i, name in enumerate(names)}
    if len(place) < len(names):
        twice = next(name for i, name in enumerate(names) if place[name] != i)
        raise ValueError(f"names: '{twice}' comes twice")
    table = SETS[wanted] if isinstance(wanted, str) else wanted
    made, sums, lacking = [], [], {}
    for name, weights in table.items():
        row = {name: 1.0} if name in place and table is ARKIT else _primitives(weights, place)
        missing = [part for part in row if part not in place]
        if missing:
            lacking[name] = missing
            continue
        made.append(name)
        total = np.zeros(given.shape[1:])
        for part, weight in row.items():
            total += weight * given[place[part]]
        sums.append(total)
    return made, np.array(sums).reshape(-1, *given.shape[1:]), lacking


def _primitives(weights: Weights, place: Mapping[str, int]) -> dict[str, float]:
    """Weights of the names that there are, through what ARKit's names are made of where these are not."""
    found: dict[str, float] = {}
    for name, weight in weights.items():
        for part, share in {name: 1.0}.items() if name in place else ARKIT.get(name, {name: 1.0}).items():
            found[part] = found.get(part, 0.0) + weight * share
    return found
