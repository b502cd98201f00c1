"""Keys of caches that hold what was computed from a design."""

from __future__ import annotations

from typing import final

from spiraltrunk.design.trunk import TrunkDesign


@final
class IdentityKey:
    """Cache key of a design by its identity, since hashing all its numbers takes as long as a solution.

    Args:
        design: the design; two equal designs have two keys.
    """

    __slots__ = ("design",)

    def __init__(self, design: TrunkDesign) -> None:
        self.design = design

    def __hash__(self) -> int:
        return id(self.design)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, IdentityKey) and self.design is other.design
