"""The table of quality: verdicts in words, an order with the worst first, and faces to look at."""

import json

VERDICTS = ("good", "look", "bad")
MEASURES = (
    "flipped_triangles",
    "torn_triangles",
    "contacts",
    "contact_gap",
    "closing",
    "strength",
    "crooked",
    "motion",
    "residual",
)

# What the panel's table can be sorted by: how bad a row is, and what it says.
ORDERS = {
    "verdict": (lambda row: VERDICTS.index(row.verdict), lambda row: reasons(row)[0].capitalize()),
    "flipped_triangles": (
        lambda row: row.flipped_triangles,
        lambda row: f"{row.flipped_triangles} turned over",
    ),
    "torn_triangles": (lambda row: row.torn_triangles, lambda row: f"{row.torn_triangles} torn"),
    "contact_gap": (lambda row: row.contact_gap, lambda row: f"{row.contact_gap:.2f} % apart"),
    "strength": (lambda row: abs(row.strength - 1), lambda row: f"{row.strength:.0%} as far"),
    "residual": (lambda row: row.residual, lambda row: f"{row.residual:.1%} off"),
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
