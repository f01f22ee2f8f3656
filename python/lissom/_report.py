"""What the classes of the module have in common."""

from __future__ import annotations

from typing import Any


class Report(dict[str, Any]):
    """A frozen dataclass whose fields are the items of a dict too: to be merged, or written as JSON."""

    def __post_init__(self) -> None:
        self.update(vars(self))
