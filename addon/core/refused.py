"""The one exception of the extension's own checks."""


class Refused(Exception):
    """The request cannot be carried out as it stands; the message says why, and what to do next."""


def first(items, limit=3):
    """The first few items and the count, for a message: ``a, b, c ... (17 in all)``."""
    items = [str(item) for item in items]
    shown = ", ".join(items[:limit])
    return shown if len(items) <= limit else f"{shown} ... ({len(items)} in all)"
