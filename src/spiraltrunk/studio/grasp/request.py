"""What the person asks for: everything that determines a trial."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import final

from spiraltrunk.design import TrunkDesign, presets
from spiraltrunk.sim.objects.catalogue import ObjectSpec
from spiraltrunk.workflows.grasp.choice.auto import AUTO


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
    option: str
    """What `--object` of the command line takes for it."""
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

    @property
    def command(self) -> str:
        """The command that does the same."""
        stage = f" --stage {self.stage}" if self.strategy == AUTO else ""
        friction = self.design.cable.friction
        return (
            f"spiraltrunk grasp {self.strategy} --object {self.option}{stage}{_format_design(self.design)} "
            f"--friction {friction:g} --seed {self.seed}"
        )


def _format_design(design: TrunkDesign) -> str:
    """The option that names the design, which has another friction here; empty for the default."""
    for name in presets.NAMES:
        preset = presets.get(name)
        if replace(design, cable=replace(design.cable, friction=preset.cable.friction)) == preset:
            return "" if name == "paper" else f" --design {name}"
    return " --design FILE.toml"
