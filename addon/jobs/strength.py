"""How strong keys are, over what a transfer made of them: kept when they are transferred again."""

from dataclasses import dataclass

from ..bridge import checks, shape_keys
from ..bridge.written import Written
from ..core.refused import Refused, first
from . import Asked, Done

LEAST, MOST = 0.05, 10.0


@dataclass(kw_only=True)
class StrengthAsked(Asked):
    """Keys of an object by name, one a line, "" for the active one, or ``every`` one that was transferred."""

    object: str = ""
    keys: str = ""
    every: bool = False
    strength: float = 1.0


@dataclass(kw_only=True)
class StrengthDone(Done):
    """``written``: the names of the keys."""

    written: list[str]


def strength_of(obj):
    """The strength of the active key."""
    key = obj.active_shape_key
    return 1.0 if key is None else Written(obj).strength(key.name)


def strengthen(context, asked):
    """Makes keys so many times as strong as they were transferred; corrections stay. A StrengthDone."""
    obj = checks.mesh_object(asked.object, context)
    checks.require_writable(obj)
    written, active = Written(obj), obj.active_shape_key
    if asked.every:
        names = [name for name in shape_keys.key_names(obj) if written.knows(name)]
    else:
        names = list(filter(None, asked.keys.splitlines())) or ([active.name] if active else [])
    keys = [shape_keys.find(obj, name) for name in names]
    foreign = [name for name in names if not written.knows(name)]
    if foreign or not names:
        which = first(repr(name) for name in foreign) if foreign else f"any key of '{obj.name}'"
        raise Refused(f"No transfer wrote {which} on the mesh as it is now: transfer first")
    for key in keys:
        shape_keys.refuse_preview(key)
    checks.require_unlocked(keys)
    for name in names:
        written.strengthen(name, asked.strength)
    written.tidy()
    told = first(repr(name) for name in names)
    return StrengthDone(summary=f"{100 * asked.strength:.0f} % as strong: {told}", warnings=[], written=names)
