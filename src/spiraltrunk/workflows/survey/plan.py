"""Plan of a survey: its trials with strategy, object and seed, independent of where and when they run.

A shard is a part of the trials for one of several machines. Trials are dealt out in turn. Each round begins with a
strategy drawn from its number: else as many shards as strategies would get one strategy each, and the slowest one most
of the work.
"""

from __future__ import annotations

import hashlib
import re
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, final

from spiraltrunk.checks import check_count
from spiraltrunk.design import presets
from spiraltrunk.design.toml import format_design, parse_design
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import DesignError
from spiraltrunk.field_docs import explain_fields
from spiraltrunk.sim.scene.options import TIMESTEP, check_timestep
from spiraltrunk.strategies.policy.library import describe_policies
from spiraltrunk.workflows.survey.user_files import describe_files

MOST_SHARDS = 10_000
"""Largest number of parts of a survey (ours)."""


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


@final
@dataclass(frozen=True, kw_only=True)
class Shard:
    """One of the equal parts of a survey."""

    number: int
    """Its number, from 1 to ``count``."""
    count: int
    """Number of parts."""

    def __post_init__(self) -> None:
        check_count("survey.shard.count", self.count, least=1, most=MOST_SHARDS)
        check_count("survey.shard.number", self.number, least=1, most=self.count)

    def __str__(self) -> str:
        return f"{self.number}/{self.count}"

    def holds(self, place: int) -> bool:
        """Whether the trial at a place among all, from 0, is in this part."""
        return place % self.count == self.number - 1


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
    shard: Shard | None = None
    """The part of the trials that is run here; None for all of them."""

    def __post_init__(self) -> None:
        check_count("survey.trials", self.trials, least=1, most=100_000)
        check_count("survey.seed", self.seed, least=0, most=2**32 - 1)
        check_timestep("survey.timestep", self.timestep)
        for name, objects in self.objects.items():
            if not objects:
                raise DesignError(f"survey.objects[{name!r}]", got=objects, allowed="one object or more")

    def entries(self) -> tuple[Entry, ...]:
        """Trials of the shard: the first of every strategy, then the second of every strategy and so on."""
        return tuple(
            Entry(strategy=name, object=objects[i % len(objects)], index=i, seed=derive_seed(self.seed, name, i))
            for i in range(self.trials)
            for k, (name, objects) in enumerate(self.objects.items())
            if self.shard is None or self.shard.holds(find_place(k, i, len(self.objects)))
        )

    def count_trials(self) -> dict[str, int]:
        """Number of the shard's trials of each strategy."""
        if self.shard is None:
            return dict.fromkeys(self.objects, self.trials)
        counted = Counter(entry.strategy for entry in self.entries())
        return {name: counted[name] for name in self.objects}

    def settings(self) -> dict[str, Any]:
        """Settings that are equal for equal surveys, ready for JSON; policies and files count by their content.

        Raises:
            DesignError: where the file of a policy, an object or the arm cannot be read.
        """
        objects = {name: list(names) for name, names in self.objects.items()}
        policies = describe_policies(tuple(objects))
        files = describe_files((name for names in objects.values() for name in names), self.design.arm)
        return {
            **({"policies": policies} if policies else {}),
            **({"files": files} if files else {}),
            "trials": self.trials,
            "seed": self.seed,
            "objects": objects,
            "design": format_design(self.design),
            "timestep_s": self.timestep,
            "shard": None if self.shard is None else str(self.shard),
        }


def find_place(strategy: int, index: int, count: int) -> int:
    """Place of a trial among all that are dealt out to shards, from 0.

    Args:
        strategy: number of its strategy, from 0.
        index: number of the trial among those of its strategy, from 0.
        count: number of strategies.
    """
    first = int.from_bytes(hashlib.sha256(f"round {index}".encode()).digest()[:4])
    return index * count + (strategy + first) % count


def parse_shard(text: str) -> Shard:
    """The shard of a text such as "2/16".

    Raises:
        DesignError: where the text is none.
    """
    matched = re.fullmatch(r"([0-9]{1,6})/([0-9]{1,6})", text)
    if matched is None or not 1 <= int(matched[1]) <= int(matched[2]) <= MOST_SHARDS:
        allowed = f"I/N, as 2/16: part I of N, I from 1 to N, N at most {MOST_SHARDS}"
        raise DesignError("survey.shard", got=text, allowed=allowed)
    return Shard(number=int(matched[1]), count=int(matched[2]))


def build_plan(settings: Mapping[str, Any]) -> SurveyPlan:
    """The plan with these settings, as of `SurveyPlan.settings`.

    Raises:
        DesignError, KeyError, TypeError, AttributeError: for settings of no plan.
    """
    return SurveyPlan(
        objects={name: tuple(names) for name, names in settings["objects"].items()},
        trials=settings["trials"],
        seed=settings["seed"],
        design=parse_design(settings["design"].encode(), "design"),
        timestep=settings["timestep_s"],
        shard=None if settings["shard"] is None else parse_shard(settings["shard"]),
    )


def derive_seed(seed: int, strategy: str, index: int) -> int:
    """A seed of 32 bits for one trial, by these arguments alone, so that the trial can be repeated alone."""
    return int.from_bytes(hashlib.sha256(f"{seed}/{strategy}/{index}".encode()).digest()[:4])
