"""Which trials a survey has: each with its strategy, object and seed, whoever runs it and whenever."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, final

from spiraltrunk.checks import check_count
from spiraltrunk.errors import DesignError

MOST_TRIALS = 100_000
"""Trials of a strategy."""

_MOST_SEED = 2**32 - 1


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
    """What its world is drawn from."""


@final
@dataclass(frozen=True, kw_only=True)
class Plan:
    """What a survey asks for."""

    objects: Mapping[str, tuple[str, ...]]
    """Objects of each strategy, which its trials take in turn."""
    trials: int
    """Trials of each strategy."""
    seed: int = 0
    """What the seeds of all trials are derived from."""

    def __post_init__(self) -> None:
        check_count("survey.trials", self.trials, least=1, most=MOST_TRIALS)
        check_count("survey.seed", self.seed, least=0, most=_MOST_SEED)
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
        """What must be the same for two surveys to be one, ready for JSON."""
        objects = {name: list(names) for name, names in self.objects.items()}
        return {"trials": self.trials, "seed": self.seed, "objects": objects}


def derive_seed(seed: int, strategy: str, index: int) -> int:
    """A seed of 32 bits for one trial, which depends on nothing else, so that the trial can be run alone."""
    return int.from_bytes(hashlib.sha256(f"{seed}/{strategy}/{index}".encode()).digest()[:4])
