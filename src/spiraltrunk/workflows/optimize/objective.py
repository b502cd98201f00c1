"""Evaluation of a candidate: success over the objects, payload and graspable range; it must be printable."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Protocol, final

from spiraltrunk.design.rules import graspable_range, payload
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import DesignError
from spiraltrunk.field_docs import explain_fields
from spiraltrunk.workflows.export.faults import find_faults
from spiraltrunk.workflows.optimize.search_space import build_candidate
from spiraltrunk.workflows.optimize.settings import SearchSettings
from spiraltrunk.workflows.survey.plan import SurveyPlan

PAYLOAD_WIDTH = 0.06
"""Width of the object for which payloads are compared [m] (ours: a can or a bottle)."""

OBJECTIVES = ("success", "payload", "range")
"""Names of what is maximised, in this order."""

RunSurvey = Callable[[SurveyPlan, Path], Mapping[str, Any]]
"""Function that runs a survey in a folder and returns its result."""


class Trials(Protocol):
    """Runs and compares surveys in folders."""

    def run(self, plan: SurveyPlan, folder: Path) -> Mapping[str, Any]:
        """Result of a survey; trials that its folder holds are not run again."""

    def compare(self, a: Path, b: Path) -> Mapping[str, Any]:
        """Paired comparison of two surveys, as of `compare_surveys`."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class Evaluation:
    """A candidate and its figures."""

    number: int
    """Its number, from 0."""
    values: Mapping[str, float]
    """Its point of the search space."""
    faults: tuple[str, ...] = ()
    """Why it cannot be printed; such a trunk is not simulated."""
    trials: int = 0
    """Objects that were tried."""
    successes: int = 0
    """Objects that were grasped by the full verdict."""
    low: float = 0.0
    """Lower end of the 95 % Wilson interval of the success rate [-]."""
    high: float = 1.0
    """Upper end of it [-]."""
    payload: float = 0.0
    """Payload at `PAYLOAD_WIDTH` by the design rules' fit [kg]."""
    range: float = 0.0
    """Largest less smallest width that the trunk wraps, by the design rules [m]."""
    causes: Mapping[str, int]
    """Failures by cause."""

    @property
    def success(self) -> float:
        """Share of the objects that were grasped [-]."""
        return self.successes / self.trials if self.trials else 0.0

    @property
    def objectives(self) -> tuple[float, float, float]:
        """Values of `OBJECTIVES`."""
        return self.success, self.payload, self.range


def plan_trials(settings: SearchSettings, design: TrunkDesign, *, are_unseen: bool = False) -> SurveyPlan:
    """One trial with each object, in the same worlds for every design."""
    objects = settings.list_objects(are_unseen=are_unseen)
    seed = settings.derive_world_seed(are_unseen=are_unseen)
    return SurveyPlan(objects={settings.strategy: objects}, trials=len(objects), seed=seed, design=design)


def find_unseen(folder: Path, settings: SearchSettings, name: str) -> Path:
    """Folder of a trunk's survey with the objects that a search has not seen, by their number and the trunk's name.

    A survey's folder holds one survey, but more candidates may change the best one.
    """
    return folder / "unseen" / str(settings.unseen) / name


def evaluate(
    number: int, values: Mapping[str, float], settings: SearchSettings, folder: Path, run_survey: RunSurvey
) -> Evaluation:
    """Evaluate a point of the search space; trials that its folder holds already are not run again.

    A point without a trunk, and one whose parts cannot be made (`find_faults`), has faults instead of trials.

    Raises:
        SurveyError: where the folder holds another survey.
        RunError: where processes cannot be started.
        OutputError: where the folder cannot be written.
    """
    try:
        design = build_candidate(values, friction=settings.friction, name=f"candidate-{number}")
    except DesignError as error:
        return Evaluation(number=number, values=values, faults=(str(error),), causes={})
    faults = find_faults(design)
    plain = Evaluation(
        number=number, values=values, faults=faults, causes={}, payload=payload(design, PAYLOAD_WIDTH),
        range=_compute_span(design),
    )  # fmt: skip
    if faults:
        return plain
    counted = run_survey(plan_trials(settings, design), folder)["strategies"][settings.strategy]
    found = {key: counted[key] for key in ("trials", "successes", "low", "high", "causes")}
    return replace(plain, **found)


def choose_best(evaluations: Sequence[Evaluation]) -> Evaluation | None:
    """The printable candidate with the highest success, the larger payload and then range among equals."""
    return max((each for each in evaluations if not each.faults), key=lambda each: each.objectives, default=None)


def find_front(evaluations: Sequence[Evaluation]) -> tuple[Evaluation, ...]:
    """Printable candidates that no other one beats or equals in all objectives and beats in one (Pareto front)."""
    printable = [each for each in evaluations if not each.faults]
    return tuple(each for each in printable if not any(_dominates(other, each) for other in printable))


def _dominates(one: Evaluation, other: Evaluation) -> bool:
    pairs = list(zip(one.objectives, other.objectives, strict=True))
    return all(a >= b for a, b in pairs) and any(a > b for a, b in pairs)


def _compute_span(design: TrunkDesign) -> float:
    widths = graspable_range(design)
    return max(0.0, widths.maximum - widths.minimum)
