"""What a use case is asked for."""

from dataclasses import fields

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
