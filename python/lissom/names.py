"""What face keys are called elsewhere: ARKit's 52, VRM's expressions, 15 visemes, as sums of ICT FaceKit's.

The names are those of Apple's ``ARFaceAnchor.BlendShapeLocation``, of the VRM 1.0 specification
(``VRMC_vrm.expressions``) and of the Oculus lip sync's visemes as engines know them. The sums of VRM and of
the visemes are ours: a start, to be corrected by eye.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

_SIDES = {"Left": "_L", "Right": "_R"}

# Apple's order and spelling.
_ARKIT: list[str] = """
    eyeBlinkLeft eyeLookDownLeft eyeLookInLeft eyeLookOutLeft eyeLookUpLeft eyeSquintLeft eyeWideLeft
    eyeBlinkRight eyeLookDownRight eyeLookInRight eyeLookOutRight eyeLookUpRight eyeSquintRight eyeWideRight
    jawForward jawLeft jawRight jawOpen mouthClose mouthFunnel mouthPucker mouthLeft mouthRight
    mouthSmileLeft mouthSmileRight mouthFrownLeft mouthFrownRight mouthDimpleLeft mouthDimpleRight
    mouthStretchLeft mouthStretchRight mouthRollLower mouthRollUpper mouthShrugLower mouthShrugUpper
    mouthPressLeft mouthPressRight mouthLowerDownLeft mouthLowerDownRight mouthUpperUpLeft mouthUpperUpRight
    browDownLeft browDownRight browInnerUp browOuterUpLeft browOuterUpRight cheekPuff cheekSquintLeft
    cheekSquintRight noseSneerLeft noseSneerRight tongueOut
""".split()  # noqa: SIM905
_BOTH = ("browInnerUp", "cheekPuff")  # of two sides in ICT FaceKit, of one in ARKit


def _ict(name: str) -> dict[str, float]:
    """{ICT's key: amount} of one of ARKit's."""
    if name in _BOTH:
        return {f"{name}_L": 1.0, f"{name}_R": 1.0}
    for side, letter in _SIDES.items():
        if name.endswith(side) and name not in ("jawLeft", "jawRight", "mouthLeft", "mouthRight"):
            return {name.removesuffix(side) + letter: 1.0}
    return {name: 1.0}


def _sum(text: str) -> dict[str, float]:
    """{ICT's key: amount} of "jawOpen 0.6, mouthSmile 0.4": a name without a side stands for both sides."""
    found: dict[str, float] = {}
    for part in filter(None, (part.strip() for part in text.split(","))):
        name, amount = part.split()
        for one in _ARKIT:
            if one in (name, f"{name}Left", f"{name}Right"):
                found |= {key: share * float(amount) for key, share in _ict(one).items()}
    return found


_VRM = {
    "happy": "mouthSmile 0.8, cheekSquint 0.6, eyeSquint 0.3, browOuterUp 0.2",
    "angry": "browDown 1, noseSneer 0.5, mouthFrown 0.5, mouthPress 0.4, eyeSquint 0.3",
    "sad": "browInnerUp 0.9, mouthFrown 0.7, eyeSquint 0.2, mouthShrugLower 0.3",
    "relaxed": "mouthSmile 0.35, eyeSquint 0.2, eyeBlink 0.25",
    "surprised": "browInnerUp 0.8, browOuterUp 0.8, eyeWide 0.8, jawOpen 0.35",
    "aa": "jawOpen 0.65, mouthLowerDown 0.2, mouthUpperUp 0.1",
    "ih": "jawOpen 0.2, mouthStretch 0.45, mouthSmile 0.15, mouthLowerDown 0.2",
    "ou": "jawOpen 0.15, mouthPucker 0.8, mouthFunnel 0.3",
    "ee": "jawOpen 0.25, mouthSmile 0.35, mouthStretch 0.35, mouthLowerDown 0.3, mouthUpperUp 0.15",
    "oh": "jawOpen 0.45, mouthFunnel 0.6, mouthPucker 0.2",
    "blink": "eyeBlink 1",
    "blinkLeft": "eyeBlinkLeft 1",
    "blinkRight": "eyeBlinkRight 1",
    "lookUp": "eyeLookUp 1",
    "lookDown": "eyeLookDown 1",
    "lookLeft": "eyeLookOutLeft 1, eyeLookInRight 1",
    "lookRight": "eyeLookInLeft 1, eyeLookOutRight 1",
    "neutral": "",
}
_VISEMES = {
    "viseme_sil": "",
    "viseme_PP": "mouthPress 0.6, mouthRollLower 0.35, mouthRollUpper 0.3",
    "viseme_FF": "jawOpen 0.08, mouthRollLower 0.6, mouthUpperUp 0.3",
    "viseme_TH": "jawOpen 0.2, mouthLowerDown 0.3, mouthUpperUp 0.1",
    "viseme_DD": "jawOpen 0.18, mouthLowerDown 0.25, mouthStretch 0.15",
    "viseme_kk": "jawOpen 0.25, mouthLowerDown 0.2, mouthUpperUp 0.15",
    "viseme_CH": "jawOpen 0.12, mouthFunnel 0.55, mouthUpperUp 0.15",
    "viseme_SS": "jawOpen 0.06, mouthStretch 0.45, mouthLowerDown 0.3, mouthUpperUp 0.15",
    "viseme_nn": "jawOpen 0.15, mouthLowerDown 0.2, mouthStretch 0.1",
    "viseme_RR": "jawOpen 0.15, mouthFunnel 0.4, mouthPucker 0.2",
    "viseme_aa": "jawOpen 0.65, mouthLowerDown 0.2, mouthUpperUp 0.1",
    "viseme_E": "jawOpen 0.3, mouthStretch 0.35, mouthSmile 0.2, mouthLowerDown 0.25",
    "viseme_I": "jawOpen 0.2, mouthStretch 0.45, mouthSmile 0.15, mouthLowerDown 0.2",
    "viseme_O": "jawOpen 0.45, mouthFunnel 0.6, mouthPucker 0.2",
    "viseme_U": "jawOpen 0.15, mouthPucker 0.8, mouthFunnel 0.3",
}

TABLES: dict[str, dict[str, dict[str, float]]] = {
    "ARKIT": {name: _ict(name) for name in _ARKIT},
    "VRM": {name: _sum(text) for name, text in _VRM.items()},
    "VISEMES": {name: _sum(text) for name, text in _VISEMES.items()},
}
"""{set: {name: {ICT's key: amount}}}, in the order of their sources."""

SETS: dict[str, tuple[str, str]] = {
    "ARKIT": ("ARKit", "51 of Apple's ARKit, as Live Link Face and VSeeFace have them: all but the tongue's"),
    "ICT": ("ICT", "The 53 of the face that comes along, left and right apart"),
    "VRM": ("VRM", "The preset expressions of VRM 1.0"),
    "VISEMES": ("Visemes", "The 15 of Oculus's lip sync"),
}
"""{set: (what people call it, what it is)}; files store places in this list: only append."""


def combined(
    kind: str, names: Sequence[str], offsets: ArrayLike
) -> tuple[list[str], NDArray[Any], list[str]]:
    """The keys of a set as sums of ICT FaceKit's.

    ``kind`` is one of ``SETS``, ``names`` (k,) ICT's with ``offsets`` (k, ...) of any shape. Returns the
    names in the set's order, their offsets (m, ...), and the names that are left out, for want of what they
    are made of. Raises ``ValueError`` for another set.
    """
    if kind not in SETS:
        raise ValueError(f"kind: expected one of {', '.join(SETS)}, not {kind!r}")
    names, offsets = list(names), np.asarray(offsets)
    if kind == "ICT":
        return names, offsets, []
    place = {name: number for number, name in enumerate(names)}
    table = TABLES[kind]
    left = [name for name, parts in table.items() if not set(parts) <= place.keys()]
    kept = [name for name in table if name not in left]
    found = np.zeros((len(kept), *offsets.shape[1:]), dtype=offsets.dtype)
    for row, name in zip(found, kept, strict=True):
        for part, amount in table[name].items():
            row += amount * offsets[place[part]]
    return kept, found, left
