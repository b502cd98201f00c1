"""Settings of a search."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from typing import Any, final

from spiraltrunk.checks import check_count, check_number
from spiraltrunk.errors import DesignError, UnknownName
from spiraltrunk.field_docs import explain_fields
from spiraltrunk.sim.objects.everyday import FAMILIES
from spiraltrunk.strategies import NAMES, get
from spiraltrunk.workflows.grasp.choice.auto import AUTO
from spiraltrunk.workflows.survey.plan import derive_seed


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class SearchSettings:
    """What is searched, how long, and on which objects."""

    candidates: int = 40
    """Trunks that are evaluated, the authors' proportions first."""
    objects: int = 20
    """Objects of the search: each candidate is tried once with each, in the same worlds."""
    unseen: int = 40
    """Objects that the search does not see, for the comparison of the best trunk with the preset paper; 0 for none."""
    strategy: str = "auto"
    """Strategy of the trials; "auto" chooses for each object."""
    kind: str | None = None
    """Class of everyday shapes that the objects are drawn from; None draws from all."""
    friction: float = 0.0
    """Coefficient of friction between cables and holes [-]."""
    seed: int = 0
    """Seed of objects, worlds and the search's choices."""

    def __post_init__(self) -> None:
        check_count("optimize.candidates", self.candidates, least=1, most=10_000)
        check_count("optimize.objects", self.objects, least=1, most=1000)
        check_count("optimize.unseen", self.unseen, least=0, most=1000)
        if self.strategy not in (AUTO, *NAMES):
            raise UnknownName("strategy", self.strategy, (AUTO, *NAMES))
        if self.strategy != AUTO and get(self.strategy).job == "kick":
            allowed = f"auto or a strategy that grasps: {', '.join(name for name in NAMES if get(name).job != 'kick')}"
            raise DesignError("optimize.strategy", got=self.strategy, allowed=allowed)
        if self.kind is not None and self.kind not in FAMILIES:
            raise UnknownName("class of everyday shapes", self.kind, FAMILIES)
        check_number("optimize.friction", self.friction, least=0.0, below=2.0)
        check_count("optimize.seed", self.seed, least=0, most=2**32 - 1)

    def list_objects(self, *, are_unseen: bool = False) -> tuple[str, ...]:
        """Names of the objects, `everyday:seed=N` with different seeds; those of the search, or those it never sees."""
        kind = "" if self.kind is None else f",kind={self.kind}"
        count, first = (self.unseen, self.objects) if are_unseen else (self.objects, 0)
        start = int.from_bytes(hashlib.sha256(f"{self.seed}/objects".encode()).digest()[:3]) * 2048
        return tuple(f"everyday:seed={start + first + i}{kind}" for i in range(count))

    def derive_world_seed(self, *, are_unseen: bool) -> int:
        """Seed of the worlds of the search, or of those that it never sees."""
        return derive_seed(self.seed, "unseen" if are_unseen else "search", 0)

    def describe(self) -> dict[str, Any]:
        """Settings that are equal for equal searches, ready for JSON; more candidates go on with the same search."""
        return {
            "objects": self.objects, "strategy": self.strategy, "kind": self.kind, "friction": self.friction,
            "seed": self.seed,
        }  # fmt: skip
