"""The face whose expressions are carried over, and the expressions that the pictures show."""

import scene

# Mixes of shape keys, by the label they get in the pictures.
SHOWN = {
    "smile": {"mouthSmile_L": 1.0, "mouthSmile_R": 1.0},
    "jaw open": {"jawOpen": 1.0},
    "snarl": {"browDown_L": 1.0, "browDown_R": 1.0, "noseSneer_L": 1.0, "noseSneer_R": 1.0},
    "funnel, brows up": {"mouthFunnel": 1.0, "browInnerUp_L": 1.0, "browInnerUp_R": 1.0},
    "wink, cheeks": {"eyeBlink_L": 1.0, "cheekPuff_L": 1.0, "cheekPuff_R": 1.0},
}


def make(face, given, location):
    """The object 'ICT face' with all its expressions as shape keys."""
    made = scene.face_object("ICT face", face, face.neutral, given, scene.collection("2 Source"), location)
    scene.add_keys(made, face.neutral, face.expressions)
    return made
