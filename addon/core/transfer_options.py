"""Labels of the options of fits and transfers: the one table for settings, presets, operators, jobs, panel
and command line.
"""

from .options import option

# A file stores the place in a list of labels: only append.
_LABELS = {
    "fit": {
        "overlap": {"label": "They Overlap"},
        "marker_tolerance": {"label": "Marker Tolerance", "high": 1.0, "soft_high": 0.1, "precision": 3},
        "match_distance": {
            "label": "Match Distance",
            "low": 1e-6,
            "high": 1.0,
            "soft_high": 0.1,
            "precision": 3,
        },
        "closest": {"label": "Tightness", "high": 1e6, "precision": 0},
    },
    "transfer": {
        "unmatched": {"label": "Loose Parts", "labels": {"follow": "Follow", "rest": "Stay"}},
        "scale": {"label": "Scale", "labels": {"target": "Target's Size", "source": "As Far"}},
        "contact": {"label": "Contact"},
        "stretch": {"label": "Longest Edge", "high": 1e6, "soft_high": 10.0},
    },
}
OPTIONS = {
    owner: {name: option(owner, name, **label) for name, label in labels.items()}
    for owner, labels in _LABELS.items()
}
MASKS = ("source_mask", "target_mask")  # of a fit: vertex groups, by name

# Flags of the command line that are not called as the option is.
FLAGS = {"closest": "tightness", "unmatched": "loose_parts"}


def values(settings, owner):
    """{name: value} of an owner's options, as ``settings`` have them."""
    return {name: getattr(settings, name) for name in OPTIONS[owner]}
