"""What the person asks for: everything that determines a trial."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

from spiraltrunk.design import TrunkDesign
from spiraltrunk.sim.objects.catalogue import ObjectSpec


@final
@dataclass(frozen=True, kw_only=True)
class GraspRequest:
    """One trial."""

    design: TrunkDesign
    """The robot, with the friction of its cables."""
    shape: ObjectSpec
    """The object."""
    name: str
    """What the object is called: a name of the catalogue, its measures, or the name of its file."""
    strategy: str
    """Name of the strategy, "auto" among them."""
    stage: str
    """What supports the object: "ground" or "hung"."""
    seed: int
    """Seed of the scene."""

    @property
    def label(self) -> str:
        """Object and strategy, in words."""
        return f"{self.name} by {self.strategy}"

    @property
    def title(self) -> str:
        """Strategy, object and seed, in one line."""
        return f"{self.strategy}, {self.name}, seed {self.seed}"
