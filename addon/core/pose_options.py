"""Every pose method and every option of it: the one table that settings, operators and panel are made of.

Names, choices and meaning are those of lissom.Pose, which refuses what this table does not know; a test
holds the two against each other.
"""

from typing import NamedTuple

import numpy as np

# Name, label, one line for the artist. A file stores the place in this list: only append.
METHODS = (
    ("laplacian", "Laplacian", "Keeps the details' vectors; fast, for small motions without turns"),
    ("laplacian_fitted", "Laplacian, fitted", "Turns and scales the details to fit; for medium turns"),
    ("rotation_invariant", "Rotation-invariant", "Spreads the handles' turns over the mesh, also full turns"),
    ("thin_shell", "Thin shell", "Stretches and bends like a thin sheet; smooth, for small motions"),
    ("poisson", "Poisson", "Blends the handles' transforms by smooth weights; fast"),
    ("multiresolution", "Multiresolution", "Poses a smooth base, then puts the details back on it"),
    ("arap", "As rigid as possible", "Keeps every small piece of the mesh rigid; for large turns and bends"),
)
_BASES = tuple(item for item in METHODS if item[0] != "multiresolution")


class Option(NamedTuple):
    """One option; the type of ``default`` is its kind: str (one of ``items``), bool, int or float."""

    label: str
    line: str
    default: object
    items: tuple = ()  # (value, label, one line); a file stores the place in this list: only append
    low: float | None = None
    high: float | None = None
    soft_high: float | None = None
    when: tuple = ()  # (name, value) of the option without which this one does nothing


def _weights(default):
    return Option(
        "Edge Weights",
        "How much each neighbour of a vertex counts",
        default,
        (
            ("cotangent", "Cotangent", "By the shape of the faces: fine and coarse parts act alike"),
            ("uniform", "Uniform", "All the same: for even meshes, and where faces are very thin"),
        ),
    )


_BORDER = Option(
    "Border Order",
    "How smoothly the pose joins the handles and the border of the region: 0 in value, 1 in slope too, "
    "2 in curvature too",
    0,
    low=0,
    high=2,
)

_COMMON = {
    "constraints": Option(
        "Handles",
        "Whether vertices of a handle go just where it takes them",
        "hard",
        (
            ("hard", "Exact", "They go exactly where the Empty takes them"),
            ("soft", "Soft", "They are pulled there, and give way to the mesh around them"),
        ),
    ),
    "weight": Option(
        "Pull",
        "How strongly soft handles pull: more holds them closer",
        1.0,
        low=1e-4,
        high=1e4,
        soft_high=10.0,
        when=("constraints", "soft"),
    ),
}

OPTIONS = {
    "common": _COMMON,  # of every method
    "laplacian": {"weights": _weights("cotangent")},
    "laplacian_fitted": {
        "weights": _weights("uniform"),
        # The core's default is the published energy, which swells where handles turn far.
        "scale": Option(
            "Scale Details",
            "Let details grow and shrink as they turn: for handles that scale; large turns swell",
            False,
        ),
    },
    "rotation_invariant": {
        "weights": _weights("cotangent"),
        "frames": Option(
            "Frames",
            "Along which edges turns are spread",
            "uniform",
            (
                ("uniform", "Uniform", "Along all edges alike"),
                ("principal", "Principal", "Rather along the directions in which the surface curves most"),
            ),
        ),
        "interpolation": Option(
            "Interpolation",
            "What is spread between the handles",
            "rotation_vector",
            (
                ("rotation_vector", "Rotations", "Axis and angle: also half a turn and more"),
                ("matrix", "Matrices", "The nine entries, as published: for turns well below half a turn"),
            ),
        ),
        "project": Option(
            "Rotations Only",
            "Make every spread matrix a rotation. Off: stretches of the handles are spread as well",
            True,
            when=("interpolation", "matrix"),
        ),
    },
    "thin_shell": {
        "k_s": Option("Stretching", "Resistance to stretching (k_s)", 1.0, low=0.0, high=1e6, soft_high=10.0),
        "k_b": Option("Bending", "Resistance to bending (k_b)", 2.0, low=0.0, high=1e6, soft_high=10.0),
        "border": _BORDER._replace(default=1),
    },
    "poisson": {"border": _BORDER},
    "multiresolution": {
        "smoothing": Option(
            "Detail Size",
            "Bumps narrower than this part of the mesh's diagonal are details, and follow the base",
            0.2,
            low=0.0,
            high=10.0,
            soft_high=1.0,
        ),
        "details": Option(
            "Details",
            "How details are put back on the posed base",
            "gradients",
            (
                ("gradients", "Turned", "Every face turns as its base does, and all are stitched"),
                ("offsets", "Offset", "Every vertex keeps its offset in the frame of its base"),
            ),
        ),
        "base": Option("Base", "The method that poses the smooth base", "poisson", _BASES),
    },
    "arap": {
        "cells": Option(
            "Cells",
            "The edges around a vertex that are kept rigid together",
            "spokes_and_rims",
            (
                ("spokes_and_rims", "Spokes and Rims", "All edges of the faces around it"),
                ("spokes", "Spokes", "Only the edges that end in it, as first published"),
            ),
        ),
        "rotation_smoothing": Option(
            "Smooth Rotations",
            "How much neighbours must turn alike: more spreads a bend over a longer stretch",
            0.0,
            low=0.0,
            high=1e4,
            soft_high=1.0,
        ),
        "smoothness": Option(
            "Smoothness",
            "How much curvature counts against lengths: 0.1 takes the spike off a single moved vertex",
            0.0,
            low=0.0,
            high=0.999,
        ),
    },
}


def options_of(method, base):
    """{(owner, name): Option} of a method in the order of the panel; "common" owns those of every method.

    The options of multiresolution's ``base`` are options of multiresolution too.
    """
    owners = (method, base, "common") if method == "multiresolution" else (method, "common")
    return {(owner, name): option for owner in owners for name, option in OPTIONS[owner].items()}


class Asked(NamedTuple):
    """How a mesh is to be posed: what a bound pose was made with, or what the settings say now."""

    method: str
    options: dict
    use_weights: bool
    weld: bool

    @classmethod
    def of(cls, method, base, use_weights, weld, value):
        """``value(owner, name)`` looks an option up; numbers become the decimals that float32 stands for."""
        options = {}
        for owner, name in options_of(method, base):
            given = value(owner, name)
            options[name] = float(str(np.float32(given))) if isinstance(given, float) else given
        return cls(method, options, use_weights, weld)


def by_name():
    """{name: Option} as lissom.Pose takes them; of a name that methods share, the first one's."""
    found = {}
    for options in OPTIONS.values():
        found = options | found
    return found
