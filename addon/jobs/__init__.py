"""Use cases as plain objects, without operator, panel or window.

Made of a context and of what is asked, a job reads the scene and refuses what cannot be carried out; its
``work``, a core.work.Work, computes and touches no scene; ``write(context, found)`` takes what the work has
found, writes it, and returns what was done. In between Blender may go on: a job keeps names and arrays, and
finds its objects anew.
"""

from dataclasses import dataclass

from ..core.asked import Asked

__all__ = ["Asked", "Done"]


@dataclass(kw_only=True)
class Done:
    """What a job has done: in one line, and what there is to warn of."""

    summary: str
    warnings: list[str]

    @property
    def kept(self):
        """The warnings that a panel keeps until they are dealt with."""
        return self.warnings
