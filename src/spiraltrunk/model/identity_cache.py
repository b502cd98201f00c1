"""Cache key of a design."""

from __future__ import annotations

from typing import final

from spiraltrunk.design.trunk import TrunkDesign


@final
class IdentityKey:
    """Key of a design by its identity, since hashing all its numbers takes as long as a solution."""

    __slots__ = ("design",)

    def __init__(self, design: TrunkDesign) -> None:
        self.design = design

    def __hash__(self) -> int:
        return id(self.design)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, IdentityKey) and self.design is other.design
