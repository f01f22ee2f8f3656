"""Labels of the pose methods and their options: the one table for settings, operators and panel."""

from typing import NamedTuple

import numpy as np

from .options import option

# A file stores the place in a list of labels: only append.
# What each is good for, as its label; what it is called in the papers goes with its line.
_METHODS = {
    "laplacian": "Drag",
    "laplacian_fitted": "Scale",
    "rotation_invariant": "Twist",
    "thin_shell": "Smooth",
    "poisson": "Fast",
    "multiresolution": "Wrinkles",
    "arap": "Natural",
    "laplacian_rotated": "Drag and Turn",
}
PAPERS = {
    "laplacian": "Laplacian editing, Sorkine et al. 2004",
    "laplacian_fitted": "Laplacian editing with fitted transformations, Sorkine et al. 2004",
    "rotation_invariant": "Rotation-invariant coordinates, Lipman et al. 2005",
    "thin_shell": "Thin shell, Botsch & Kobbelt 2004",
    "poisson": "Poisson editing, Yu et al. 2004",
    "multiresolution": "Multiresolution editing, Kobbelt et al. 1998",
    "arap": "As rigid as possible, Sorkine & Alexa 2007",
    "laplacian_rotated": "Laplacian editing with estimated rotations, Lipman et al. 2004",
}
SHOWN_FIRST = ("arap", "thin_shell", "poisson", "rotation_invariant", "multiresolution")
METHODS = option("pose", "method", "Method", _METHODS).items  # (name, label, one line)

_BASES = {name: label for name, label in _METHODS.items() if name != "multiresolution"}
_WEIGHTS = {"label": "Edge Weights", "labels": {"cotangent": "Cotangent", "uniform": "Uniform"}}
_STIFF = {"high": 1e6, "soft_high": 10.0}

_LABELS = {
    "common": {
        "constraints": {"label": "Handles", "labels": {"hard": "Exact", "soft": "Soft"}},
        "weight": {"label": "Pull", "low": 1e-4, "high": 1e4, "soft_high": 10.0},
        "preserve_volume": {"label": "Keep Volume"},
        "unheld": {"label": "Loose Parts", "labels": {"follow": "Follow", "rest": "Rest"}},
    },
    "laplacian": {"weights": _WEIGHTS},
    "laplacian_fitted": {
        "weights": _WEIGHTS,
        # The core's default is the published energy, which swells where handles turn far.
        "scale": {"label": "Scale Details", "default": False},
    },
    "rotation_invariant": {
        "weights": _WEIGHTS,
        "frames": {"label": "Frames", "labels": {"uniform": "Uniform", "principal": "Principal"}},
        "interpolation": {
            "label": "Interpolation",
            "labels": {"rotation_vector": "Rotations", "matrix": "Matrices"},
        },
        "project": {"label": "Rotations Only"},
    },
    "thin_shell": {
        "k_s": {"label": "Stretching", **_STIFF},
        "k_b": {"label": "Bending", **_STIFF},
        "border": {"label": "Border Order"},
    },
    "poisson": {"border": {"label": "Border Order"}, "solid": {"label": "Solid"}},
    "multiresolution": {
        "smoothing": {"label": "Detail Size", "high": 10.0, "soft_high": 1.0},
        "details": {"label": "Details", "labels": {"gradients": "Turned", "offsets": "Offset"}},
        "base": {"label": "Base", "labels": _BASES},
    },
    "arap": {
        "cells": {
            "label": "Cells",
            "labels": {"spokes_and_rims": "Spokes and Rims", "spokes": "Spokes"},
        },
        "rotation_smoothing": {"label": "Smooth Rotations", "high": 1e4, "soft_high": 1.0},
        "smoothness": {"label": "Smoothness", "high": 0.999},
        "solid": {"label": "Solid"},
    },
    "laplacian_rotated": {
        "weights": _WEIGHTS,
        "estimate": {"label": "Estimate Over", "high": 10.0, "soft_high": 0.5},
    },
}

OPTIONS = {  # {owner: {name: Option}}; "common" owns those of every method
    owner: {
        name: option("pose" if owner == "common" else f"pose.{owner}", name, **label)
        for name, label in labels.items()
    }
    for owner, labels in _LABELS.items()
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
    stays: str
    reach: float
    symmetry: str

    @classmethod
    def of(cls, settings, base, value):
        """``settings`` has what is no option of lissom.Pose, ``value(owner, name)`` looks such an option up.

        Numbers become the decimals that float32 stands for.
        """
        options = {}
        for owner, name in options_of(settings.method, base):
            options[name] = _decimal(value(owner, name))
        own = (
            settings.use_weights,
            settings.weld,
            settings.stays,
            _decimal(settings.reach),
            settings.symmetry,
        )
        return cls(settings.method, options, *own)


def _decimal(value):
    return float(str(np.float32(value))) if isinstance(value, float) else value


def by_name():
    """{name: Option} as lissom.Pose takes them; of a name that methods share, the first one's."""
    found = {}
    for options in OPTIONS.values():
        found = options | found
    return found
