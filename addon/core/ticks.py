"""A list of names of which some are ticked."""

from .refused import Refused, first

ACTIONS = [("TOGGLE", "Toggle", "One key"), ("ALL", "All", "All keys"), ("NONE", "None", "No key")]


def ticked(known, chosen, action, name):
    """Those of the ``known`` names that are ticked after an action, where ``chosen`` are before.

    "TOGGLE" turns the tick of one ``name``; Refused where that is not known.
    """
    if action != "TOGGLE":
        return list(known) if action == "ALL" else []
    if name not in known:
        raise Refused(f"There is no shape key named '{name}' to tick: there are {first(known)}")
    return [one for one in known if (one in chosen) != (one == name)]
