"""Optuna's sampler: proposes the next point, and keeps the journal of all points.

The sampler is made anew for each candidate, with a seed of its own, so that it depends on the journal alone: an
interrupted search goes on as if it had not been interrupted.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, final

from spiraltrunk.errors import OutputError, describe
from spiraltrunk.workflows.optimize.objective import OBJECTIVES, Evaluation
from spiraltrunk.workflows.optimize.search_space import SPACE
from spiraltrunk.workflows.survey.plan import derive_seed

STUDY = "trunk"
"""Name of the study in the journal."""

_RANDOM = 10
"""Candidates drawn at random before the sampler uses the results of earlier ones [-] (Optuna's default)."""


@final
class Sampler:
    """Proposals of a search, kept in a journal.

    Args:
        journal: its file; the caller has the folder's lock.
        seed: seed of the search.

    Raises:
        OutputError: for a file that is no journal.
    """

    def __init__(self, journal: Path, seed: int) -> None:
        import optuna
        from optuna.storages import JournalStorage
        from optuna.storages.journal import JournalFileBackend

        optuna.logging.set_verbosity(optuna.logging.ERROR)
        self._seed = seed
        try:
            _drop_torn_line(journal)
            storage = JournalStorage(JournalFileBackend(str(journal), lock_obj=_FolderLock()))  # type: ignore[arg-type]
            self._study = optuna.create_study(
                storage=storage, study_name=STUDY, directions=["maximize"] * len(OBJECTIVES), load_if_exists=True
            )
            self._trials()
        except Exception as error:
            allowed = "allowed: the folder of a search, or a new one"
            raise OutputError(f"{str(journal)!r} is no journal of a search: {describe(error)}; {allowed}") from error

    def ask(self) -> tuple[int, dict[str, float]]:
        """The next point and its number: one that was begun and not evaluated, or a new one."""
        from optuna.trial import TrialState

        for trial in self._trials():
            if trial.state == TrialState.RUNNING and set(trial.params) == {each.name for each in SPACE}:
                return trial.number, _read(trial.params)
            if trial.state == TrialState.RUNNING:  # Killed while it was drawn.
                self._study.tell(trial.number, state=TrialState.FAIL)
        number, first = len(self._trials()), {each.name: _round(each.first, each.step) for each in SPACE}
        if not self._has_queued(first):
            self._study.enqueue_trial(first)
        self._study.sampler = self._build(number)
        trial = self._study.ask()
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            for each in SPACE:
                if each.step is None:
                    trial.suggest_float(each.name, each.least, each.most)
                else:
                    trial.suggest_int(each.name, int(each.least), int(each.most), step=each.step)
        return trial.number, _read(trial.params)

    def tell(self, evaluation: Evaluation) -> None:
        """Store an evaluated point."""
        self._study.sampler = self._build(evaluation.number, n_fault=len(evaluation.faults))
        self._study.tell(evaluation.number, list(evaluation.objectives))

    def list_evaluated(self) -> list[tuple[int, dict[str, float]]]:
        """Numbers and points of the candidates that were evaluated."""
        from optuna.trial import TrialState

        return [(trial.number, _read(trial.params)) for trial in self._trials() if trial.state == TrialState.COMPLETE]

    def _has_queued(self, point: Mapping[str, float]) -> bool:
        """Whether a trial has a point that was queued; one that a kill cut off while it was drawn has not."""
        from optuna.trial import TrialState

        kept = [trial for trial in self._trials() if trial.state != TrialState.FAIL]
        return any(trial.system_attrs.get("fixed_params") == point for trial in kept)

    def _build(self, number: int, n_fault: int = 0) -> Any:
        """The sampler of one candidate; the number of its faults is a constraint, feasible at 0."""
        from optuna.samplers import TPESampler

        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return TPESampler(
                seed=derive_seed(self._seed, "ask", number), n_startup_trials=_RANDOM,
                constraints_func=lambda _: (float(n_fault),),
            )  # fmt: skip

    def _trials(self) -> Sequence[Any]:
        return list(self._study.get_trials(deepcopy=False))


@final
class _FolderLock:
    """No lock of its own: one process writes to the folder, which is locked."""

    def acquire(self) -> bool:
        """Optuna asks for it."""
        return True

    def release(self) -> None:
        """Optuna asks for it."""


def _drop_torn_line(journal: Path) -> None:
    """Remove a last line that a crash cut off; Optuna would join the next one to it."""
    if journal.exists():
        data = journal.read_bytes()
        whole = data.rfind(b"\n") + 1
        if whole < len(data):
            with journal.open("r+b") as file:
                file.truncate(whole)


def _round(value: float, step: int | None) -> float | int:
    return value if step is None else round(value)


def _read(params: Mapping[str, Any]) -> dict[str, float]:
    values = {name: float(params[name]) for name in (each.name for each in SPACE)}
    assert all(math.isfinite(value) for value in values.values())
    return values
