"""Recordings compared with a model: deviations run by run, as figures ready for JSON."""

from __future__ import annotations

import math
import platform
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.metadata import version
from typing import Any, final

import numpy as np

import spiraltrunk
from spiraltrunk.errors import TakeError
from spiraltrunk.mocap.protocol.protocol import Protocol
from spiraltrunk.mocap.session.session import RunShapes, Session, SessionSettings, Tell, build_session, register
from spiraltrunk.mocap.signal.deviation import PAPER, Deviation, compute_deviation
from spiraltrunk.mocap.signal.registration import KINDS as ALIGNMENTS
from spiraltrunk.mocap.signal.registration import Alignment

_MADE_UP = ("rehearsal", "virtual", "simulat")
"""Words in a take's name by which it says that no trunk was recorded."""


@final
@dataclass(frozen=True, kw_only=True)
class Judgement:
    """What recordings say of a model."""

    protocol: Protocol
    """What was done."""
    settings: SessionSettings
    """How recordings were read, and the model."""
    session: Session
    """Their shapes."""
    deviations: tuple[Deviation, ...]
    """Distances from the model, run by run."""


def judge(
    protocol: Protocol, takes: dict[str, list[str]], settings: SessionSettings, tell: Tell | None = None
) -> Judgement:
    """Read recordings and hold them against the model.

    Args:
        protocol: what was done.
        takes: files by the name of their run.
        settings: trunk, axes, model and registration.
        tell: called as the work goes on.

    Raises:
        TakeError: for recordings that cannot be read or do not hold what the protocol says.
        ModelError: for a model that does not know the trunk.
    """
    session = build_session(protocol, takes, settings, tell)
    return Judgement(
        protocol=protocol, settings=settings, session=session, deviations=tuple(map(_deviate, session.runs))
    )


def _deviate(run: RunShapes) -> Deviation:
    return compute_deviation(run.points, run.predicted.points, run.rotation, run.predicted.rotation)


def compute_result(judgement: Judgement, files: Sequence[str] = ()) -> dict[str, Any]:
    """Everything in plain values, ready for JSON."""
    settings, runs = judgement.settings, judgement.session.runs
    pairs = list(zip(runs, judgement.deviations, strict=True))
    return {
        "model": settings.model,
        "friction": _tell_friction(settings),
        "design": settings.design.name,
        "protocol": judgement.protocol.name,
        "axes": settings.axes or judgement.protocol.axes,
        "alignment": str(judgement.session.alignment),
        "is_made_up": bool(_find_made_up(runs)),
        "runs": {run.plan.run.name: _tell_run(run, deviation) for run, deviation in pairs},
        "mean_rmse_by_alignment_m": {
            str(alignment): _compare_alignment(judgement, alignment) for alignment in _list_alignments(judgement)
        },
        "paper": PAPER,
        "notes": [*_warn(runs), *(note for run in runs for note in run.notes)],
        "versions": {
            "spiraltrunk": spiraltrunk.__version__, "python": platform.python_version(), "numpy": version("numpy")
        },
        "files": list(files),
    }  # fmt: skip


def _find_made_up(runs: Sequence[RunShapes]) -> list[str]:
    """Recordings that say of themselves that no trunk was recorded."""
    takes = [take.take for run in runs for take in run.takes]
    return [take.source for take in takes if any(word in take.name.lower() for word in _MADE_UP)]


def _warn(runs: Sequence[RunShapes]) -> list[str]:
    """Say of recordings that were made up that they measure nothing."""
    made = _find_made_up(runs)
    return [f"not a measurement: {len(made)} recordings are made up, such as {made[0]}"] if made else []


def _tell_friction(settings: SessionSettings) -> float | None:
    if settings.model == "reference":
        return None
    return settings.design.cable.friction if settings.friction is None else settings.friction


def _tell_run(run: RunShapes, deviation: Deviation) -> dict[str, Any]:
    sections = deviation.sections
    return {
        "kind": run.plan.run.kind,
        "tilt_deg": _tilt(run),
        "shapes": len(run.points),
        "sections": sections,
        "rmse_per_shape_m": deviation.per_shape.tolist(),
        "rmse_per_section_m": deviation.per_section[np.array(sections) - 1].tolist(),
        "mean_rmse_m": deviation.mean_rmse,
        "max_rmse_m": deviation.max_rmse,
        "max_deviation_m": deviation.max_deviation,
        "mean_turn_deg": _number(math.degrees(deviation.mean_turn)),
        "spread_of_takes_m": _number(run.spread),
        "takes": [
            {
                "file": take.take.source,
                "name": take.take.name,
                "recorded": take.take.started,
                "times_s": [[held.still.begin, held.still.end] for held in take.held],
            }
            for take in run.takes
        ],
    }


def _number(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _tilt(run: RunShapes) -> float:
    return round(90.0 - math.degrees(run.plan.run.theta_0), 9) + 0.0


def _list_alignments(judgement: Judgement) -> list[Alignment]:
    """The plain ones, and the chosen one where it is on chosen sections."""
    plain, chosen = [Alignment(kind=kind) for kind in ALIGNMENTS], judgement.session.alignment
    return plain if chosen in plain else [*plain, chosen]


def _compare_alignment(judgement: Judgement, alignment: Alignment) -> dict[str, float | None]:
    """Mean RMSE of each run, had it been aligned so; None where that cannot be."""
    found: dict[str, float | None] = {}
    for run in judgement.session.runs:
        try:
            points, _ = register(run.plan, run.predicted, run.takes, alignment, [])
        except TakeError:
            found[run.plan.run.name] = None
            continue
        seen = np.isfinite(points).all(axis=-1)
        count = seen.sum(axis=0)
        mean = np.where(seen[..., None], points, 0.0).sum(axis=0) / np.where(count > 0, count, np.nan)[..., None]
        found[run.plan.run.name] = compute_deviation(mean, run.predicted.points).mean_rmse
    return found
