"""Use cases as plain objects, without operator, panel or window.

Made of a context and of what is asked, a job reads the scene and refuses what cannot be carried out; its
``work``, a core.work.Work, computes and touches no scene; ``write(context, found)`` takes what the work has
found, writes it, and returns what was done. In between Blender may go on: a job keeps names and arrays, and
finds its objects anew.
"""

from dataclasses import dataclass, fields

import numpy as np


class Asked:
    """Mixin of dataclasses of what a job is asked for."""

    def __post_init__(self):
        for one in fields(self):  # as Blender's properties have them: the same result whoever asks
            value = getattr(self, one.name)
            if isinstance(value, float):
                setattr(self, one.name, float(np.float32(value)))

    @classmethod
    def of(cls, settings, **also):
        """As an operator or other settings have it, which may lack what has a default."""
        known = {one.name: getattr(settings, one.name) for one in fields(cls) if hasattr(settings, one.name)}
        return cls(**known | also)


@dataclass(kw_only=True)
class Done:
    """What a job has done: in one line, and what there is to warn of."""

    summary: str
    warnings: list[str]
