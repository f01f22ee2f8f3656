"""Landmarks: sets of named places to mark in turn, what each is called and where it is in a small picture.

The picture's coordinates are hundredths of its size, from -50 to 50, upward; left is the subject's own left,
which one sees on the right.
"""

from typing import NamedTuple

# The 68 of Multi-PIE (Gross et al. 2010), in their order, with the lids and lips of a face at rest.
_JAW = [(-50, 29), (-49, 15), (-47, 1), (-45, -12), (-39, -26), (-29, -38), (-21, -42), (-10, -45)]
_BROW = [(-39, 40), (-33, 45), (-26, 47), (-16, 47), (-8, 45)]
_NOSE = [(0, 30), (0, 22), (0, 15), (0, 7)]
_NOSTRILS = [(-9, -3), (-4, -3)]
_EYE = [(-30, 28), (-26, 31), (-19, 31), (-13, 27), (-19, 25), (-26, 25)]
_UPPER_LIP = [(-17, -19), (-12, -14), (-5, -12), (0, -12)]
_LOWER_LIP = [(-12, -23), (-7, -25), (0, -25)]
_INNER_LIP = [(-15, -19), (-7, -18), (0, -18)]

_JAW_NAMES = ["ear", "cheek 1", "cheek 2", "cheek 3", "corner of the jaw", "jaw 1", "jaw 2", "jaw 3"]
_BROW_NAMES = ["outer end", "outer part", "middle", "inner part", "inner end"]
_EYE_NAMES = ["outer corner", "upper lid, outer", "upper lid, inner", "inner corner"]
_EYE_NAMES += ["lower lid, inner", "lower lid, outer"]


class Landmark(NamedTuple):
    """One of a set: its name, and where it is in the picture."""

    name: str
    spot: tuple[int, int]


def _both(what, names, spots, left_reversed=True):
    """The right ones in their order, then the left ones, by default from the middle outward."""
    right = [Landmark(f"right {what}{name}", spot) for name, spot in zip(names, spots, strict=True)]
    left = [Landmark(name.name.replace("right", "left", 1), (-name.spot[0], name.spot[1])) for name in right]
    return right, left[::-1] if left_reversed else left


def _face():
    jaw, other_jaw = _both("", _JAW_NAMES, _JAW)
    brow, other_brow = _both("brow, ", _BROW_NAMES, _BROW)
    nose = [Landmark(f"ridge of the nose {i + 1}", spot) for i, spot in enumerate(_NOSE[:3])]
    nose.append(Landmark("tip of the nose", _NOSE[3]))
    nostrils, others = _both("nostril, ", ["wing", "inside"], _NOSTRILS)
    eye, other_eye = _both("eye, ", _EYE_NAMES, _EYE, left_reversed=False)
    other_eye = [other_eye[i] for i in (3, 2, 1, 0, 5, 4)]
    upper, other_upper = _both("", ["corner of the mouth", "upper lip 1", "upper lip 2"], _UPPER_LIP[:3])
    lower, other_lower = _both("", ["lower lip 1", "lower lip 2"], _LOWER_LIP[:2], left_reversed=False)
    inner, other_inner = _both("", ["corner of the mouth, inside", "upper lip, inside"], _INNER_LIP[:2])
    under, other_under = _both("", ["lower lip, inside"], [(-7, -18)])
    return [
        *jaw, Landmark("chin", (0, -47)), *other_jaw,
        *brow, *other_brow,
        *nose, *nostrils, Landmark("base of the nose", (0, -4)), *others,
        *eye, *other_eye,
        *upper, Landmark("upper lip, middle", (0, -12)), *other_upper,
        *other_lower, Landmark("lower lip, middle", (0, -25)), *lower[::-1],
        *inner, Landmark("upper lip, inside, middle", (0, -18)), *other_inner,
        *other_under, Landmark("lower lip, inside, middle", (0, -19)), *under,
    ]  # fmt: skip


_BODY = [
    ("top of the head", (0, 50)), ("chin", (0, 37)), ("base of the neck", (0, 31)),
    ("right shoulder", (-11, 29)), ("right elbow", (-24, 20)), ("right wrist", (-36, 13)),
    ("right middle finger, tip", (-44, 9)), ("right thumb, tip", (-39, 7)), ("right armpit", (-9, 24)),
    ("left shoulder", (11, 29)), ("left elbow", (24, 20)), ("left wrist", (36, 13)),
    ("left middle finger, tip", (44, 9)), ("left thumb, tip", (39, 7)), ("left armpit", (9, 24)),
    ("breastbone", (0, 23)), ("navel", (0, 9)), ("crotch", (0, -2)),
    ("right hip", (-9, 2)), ("right knee", (-8, -22)), ("right ankle", (-8, -43)), ("right toes", (-11, -49)),
    ("left hip", (9, 2)), ("left knee", (8, -22)), ("left ankle", (8, -43)), ("left toes", (11, -49)),
]  # fmt: skip

FACE = _face()
_SEVEN = (36, 39, 42, 45, 30, 48, 54)
_MORE = (0, 4, 8, 12, 16, 17, 21, 22, 26, 31, 33, 35, 37, 44, 51, 57, 27)

# Where the openings of eyes and mouth have their middles: enough to find the rest by.
MIDDLES = [
    Landmark("left eye, middle", (21, 28)),
    Landmark("right eye, middle", (-21, 28)),
    Landmark("mouth, middle", (0, -19)),
]

SETS = {
    "FACE_3": MIDDLES,
    "FACE_7": [FACE[i] for i in _SEVEN],
    "FACE_24": [FACE[i] for i in (*_SEVEN, *_MORE)],
    "FACE_68": FACE,
    "BODY": [Landmark(name, spot) for name, spot in _BODY],
}

# Lines of the pictures, each through places by their numbers in the largest set of its kind.
FACE_LINES = [
    range(17), range(17, 22), range(22, 27), range(27, 31), range(31, 36),
    [*range(36, 42), 36], [*range(42, 48), 42], [*range(48, 60), 48], [*range(60, 68), 60],
]  # fmt: skip
BODY_LINES = [
    (0, 1, 2, 15, 16, 17), (2, 3, 4, 5, 6), (5, 7), (2, 9, 10, 11, 12), (11, 13),
    (17, 18, 19, 20, 21), (17, 22, 23, 24, 25),
]  # fmt: skip


def picture(kind):
    """The lines of a set's picture: lists of spots; none for sets of one's own."""
    if kind == "BODY":
        return [[SETS["BODY"][i].spot for i in line] for line in BODY_LINES]
    return [[FACE[i].spot for i in line] for line in FACE_LINES] if kind in SETS else []


def mirrored(name):
    """That of the same landmark on the other side, or the same name for one in the middle."""
    for side, other in (("left", "right"), ("right", "left")):
        if name.startswith(side):
            return other + name.removeprefix(side)
    return name


def is_own_name(name):
    """Whether a marker was given a name, rather than a number by us."""
    head, _, number = name.rpartition(" ")
    return bool(name) and not (head in ("Marker", "Suggested") and number.isdigit())


def upcoming(names, marked, skipped):
    """The first of these names that is neither marked nor skipped, or None."""
    return next((name for name in names if name not in marked and name not in skipped), None)
