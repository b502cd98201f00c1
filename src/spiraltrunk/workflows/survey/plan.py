"""Plan of a survey: its trials with strategy, object and seed, independent of where and when they run."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, final

from spiraltrunk.checks import check_count
from spiraltrunk.design import presets
from spiraltrunk.design.toml import format_design
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import DesignError
from spiraltrunk.field_docs import explain_fields
from spiraltrunk.sim.scene.options import TIMESTEP, check_timestep


@final
@dataclass(frozen=True, kw_only=True)
class Entry:
    """One trial to run."""

    strategy: str
    """Name of the strategy."""
    object: str
    """Name of the object, or its measures as a text."""
    index: int
    """Number of the trial among those of its strategy, from 0."""
    seed: int
    """Seed of its scene."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class SurveyPlan:
    """Strategies, objects and number of trials."""

    objects: Mapping[str, tuple[str, ...]]
    """Objects of each strategy, taken in turn by its trials."""
    trials: int
    """Trials of each strategy."""
    seed: int = 0
    """Seed that the seeds of all trials are derived from."""
    design: TrunkDesign = presets.PAPER
    """Robot of every trial."""
    timestep: float = TIMESTEP
    """Time step of the physics [s]."""

    def __post_init__(self) -> None:
        check_count("survey.trials", self.trials, least=1, most=100_000)
        check_count("survey.seed", self.seed, least=0, most=2**32 - 1)
        check_timestep("survey.timestep", self.timestep)
        for name, objects in self.objects.items():
            if not objects:
                raise DesignError(f"survey.objects[{name!r}]", got=objects, allowed="one object or more")

    def entries(self) -> tuple[Entry, ...]:
        """All trials: the first of every strategy, then the second of every strategy and so on."""
        return tuple(
            Entry(strategy=name, object=objects[i % len(objects)], index=i, seed=derive_seed(self.seed, name, i))
            for i in range(self.trials)
            for name, objects in self.objects.items()
        )

    def settings(self) -> dict[str, Any]:
        """Settings that are equal for equal surveys, ready for JSON."""
        objects = {name: list(names) for name, names in self.objects.items()}
        return {
            "trials": self.trials,
            "seed": self.seed,
            "objects": objects,
            "design": format_design(self.design),
            "timestep_s": self.timestep,
        }


def derive_seed(seed: int, strategy: str, index: int) -> int:
    """A seed of 32 bits for one trial, by these arguments alone, so that the trial can be repeated alone."""
    return int.from_bytes(hashlib.sha256(f"{seed}/{strategy}/{index}".encode()).digest()[:4])
