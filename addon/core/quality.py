"""The table of quality: verdicts in words, an order with the worst first, and faces to look at."""

import json
from typing import NamedTuple

VERDICTS = ("good", "look", "bad")


class Measure(NamedTuple):
    """A number of each key: what the panel calls it, what it is, what it is where all is well."""

    label: str
    line: str
    fine: float = 0.0


# Those of lissom.Quality, as the settings and reports have them.
MEASURES = {
    "flipped_triangles": Measure("Flipped", "Triangles of the target that are turned over", 0),
    "torn_triangles": Measure("Torn", "Triangles 2.5 times as long as was asked", 0),
    "contacts": Measure("Contacts", "Vertices of the target that meet another surface", 0),
    "contact_gap": Measure(
        "Gap", "How much wider apart they are than on the source, in percent of the target's size"
    ),
    "closing": Measure("Closing", "What part of the way they come together", 1.0),
    "amplitude": Measure("Amplitude", "Motion over that of the source, as Scale has it", 1.0),
    "crooked": Measure("Crooked", "Difference of left and right where there is none on the source"),
    "covered": Measure(
        "Covered", "What part of what moves on the source has a counterpart on the target", 1.0
    ),
    "motion": Measure("Motion", "Largest motion, in percent of the target's size"),
    "residual": Measure("Residual", "How far the key is from what was asked of each face, of its own size"),
}

# What the panel's table can be sorted by: how bad a row is, what it says, what that is. Files store places
# in this list: only append.
ORDERS = {
    "verdict": (
        lambda row: VERDICTS.index(row.verdict),
        lambda row: reasons(row)[0].capitalize(),
        "Bad keys, then those that deserve a look",
    ),
    "flipped_triangles": (
        lambda row: row.flipped_triangles,
        lambda row: f"{row.flipped_triangles} turned over",
        "Faces that are turned over",
    ),
    "torn_triangles": (
        lambda row: row.torn_triangles,
        lambda row: f"{row.torn_triangles} torn",
        "Faces that are stretched beyond what was asked",
    ),
    "contact_gap": (
        lambda row: row.contact_gap,
        lambda row: f"{row.contact_gap:.2f} % apart",
        "Lids and lips that stay apart",
    ),
    "amplitude": (
        lambda row: abs(row.amplitude - 1),
        lambda row: f"{100 * row.amplitude:.0f} % as far",
        "Motions that are lost or exaggerated",
    ),
    "residual": (
        lambda row: row.residual,
        lambda row: f"{100 * row.residual:.1f} % off",
        "How far the key is from what was asked of each face",
    ),
    "covered": (
        lambda row: -row.covered,
        lambda row: f"{100 * row.covered:.0f} % has a counterpart",
        "Motions that have no counterpart on the target",
    ),
}


def reasons(row):
    """Why a row is not good, the worst first; that it is good where there are none."""
    return [line for line in row.reasons.splitlines() if line] or ["good"]


def badness(row, order="verdict"):
    """Rows with more of it come first; those of one verdict by their residual."""
    return ORDERS[order][0](row), row.residual


def pack_faces(faces):
    """{name of an object: face indices} as text that a property holds; objects without any are left out."""
    return json.dumps({name: [int(face) for face in own] for name, own in faces.items() if len(own)})


def unpack_faces(text):
    """What ``pack_faces`` has packed."""
    return json.loads(text) if text else {}


def as_dict(row):
    """A row as it is written to a file."""
    told = [line for line in row.reasons.splitlines() if line]
    found = {"name": row.name, "verdict": row.verdict, "reasons": told, "faces": unpack_faces(row.faces)}
    return found | {measure: getattr(row, measure) for measure in MEASURES}


def as_dicts(rows):
    """A table as it is written to a file, the worst first."""
    return [as_dict(row) for row in sorted(rows, key=badness, reverse=True)]
