"""Designs as keys of what is kept for them, told apart by identity."""

from __future__ import annotations

from typing import final

from spiraltrunk.design.trunk import TrunkDesign


@final
class Same:
    """A design as a key: a design's own hash, of all its numbers, takes as long as a solution.

    Args:
        design: the design; of two with the same numbers each is prepared by itself.
    """

    __slots__ = ("design",)

    def __init__(self, design: TrunkDesign) -> None:
        self.design = design

    def __hash__(self) -> int:
        return id(self.design)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Same) and self.design is other.design
