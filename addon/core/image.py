"""Labels and ends of sliders of the options of lissom.image_mesh."""

LABELS = {
    "edge": {"label": "Edge Length", "high": 1000.0, "soft_high": 50.0},
    "threshold": {"label": "Threshold", "low": 0.001},
    "tolerance": {"label": "Tolerance", "high": 100.0, "soft_high": 5.0},
    "smallest": {"label": "Smallest", "high": 1e6, "soft_high": 100.0},
}
