"""One purchased item at one place of the robot."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

from spiraltrunk.field_docs import explain_fields


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class Purchase:
    """A row of the bill: an item for one place; the guide takes each row in one step."""

    kind: str
    """Heading in the bill."""
    item: str
    """What it is."""
    count: int
    """Number of pieces."""
    size: str = ""
    """Dimensions or rating."""
    material: str = ""
    """Material."""
    place: str
    """Where it goes."""
    note: str = ""
    """Remark."""

    def __str__(self) -> str:
        """Count, item and size, as the guide lists them."""
        return f"{self.count} x {self.item}" + (f" {self.size}" if self.size else "")
