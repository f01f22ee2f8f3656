"""The faces whose expressions are carried over, and the mixes of them that the pictures show."""

import scene

# What Suzanne has too: no sockets, teeth and tongue.
SKIN = ("face", "head_and_neck")


def _both(name, value=1.0):
    return {f"{name}_L": value, f"{name}_R": value}


MIXES = {
    "joy": {**_both("mouthSmile"), **_both("browInnerUp", 0.4)},
    "surprise": {"jawOpen": 1.0, **_both("browInnerUp")},
    "anger": {**_both("browDown"), **_both("noseSneer"), **_both("mouthFrown")},
    "kiss": {"mouthPucker": 1.0, "mouthFunnel": 0.5},
}
WINK = {"wink": {"eyeBlink_L": 1.0, **_both("cheekPuff", 0.8)}}
BLINK = {"blink": _both("eyeBlink")}


def make(name, face, given, into, location):
    """An object of the face with all its expressions as shape keys."""
    made = scene.face_object(name, face, face.neutral, given, into, location)
    scene.add_keys(made, face.neutral, face.expressions)
    return made
