"""``--strengths``: how strong single keys are, over what was transferred."""

from ..core.refused import Refused
from ..jobs.strength import LEAST, MOST, StrengthAsked, strengthen


def configure(add):
    """Adds the argument by ``add_argument`` of a parser."""
    add(
        "--strengths",
        nargs="+",
        default=[],
        metavar="KEY=FACTOR",
        help="how strong keys are over what was transferred, as jawOpen=0.8; transferred again, they stay so",
    )


def read(arguments):
    """{key: factor} of the argument."""
    found = {}
    for told in arguments.strengths:
        name, _, factor = told.rpartition("=")
        try:
            found[name] = float(factor)
        except ValueError:
            found[name] = 0.0
        if not name or not LEAST <= found[name] <= MOST:
            raise Refused(f"--strengths: '{told}' is not KEY=FACTOR with a factor from {LEAST} to {MOST:g}")
    return found


def apply(context, strengths, objects):
    """Makes keys of each of ``objects`` that has them so strong; returns an error for each that none has."""
    errors = []
    for name, factor in strengths.items():
        having = [obj for obj in objects if obj.data.shape_keys and name in obj.data.shape_keys.key_blocks]
        for obj in having:
            try:
                strengthen(context, StrengthAsked(object=obj.name, keys=name, strength=factor))
            except Refused as error:
                errors.append(f"--strengths: {error}")
        if not having:
            errors.append(f"--strengths: no object has a shape key named '{name}'")
    return errors
