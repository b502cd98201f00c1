"""Recordings compared with a model: deviations of each run, as figures ready for JSON."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, final

import numpy as np

from spiraltrunk.errors import TakeError
from spiraltrunk.files.results import Progress, ignore_progress, read_versions, to_json
from spiraltrunk.mocap.protocol.protocol import Protocol
from spiraltrunk.mocap.session.session import RunShapes, Session, SessionSettings, build_session
from spiraltrunk.mocap.session.take_registration import average_takes, register
from spiraltrunk.mocap.signal.deviation import PAPER, Deviation, compute_deviation
from spiraltrunk.mocap.signal.registration import KINDS as ALIGNMENTS
from spiraltrunk.mocap.signal.registration import Alignment


@final
@dataclass(frozen=True, kw_only=True)
class Comparison:
    """Recordings and their deviations from a model."""

    protocol: Protocol
    """The protocol that was recorded."""
    settings: SessionSettings
    """How recordings were read, and the model."""
    session: Session
    """Measured shapes."""
    deviations: tuple[Deviation, ...]
    """Distances from the model, run by run."""


def compare_to_model(
    protocol: Protocol, takes: dict[str, list[str]], settings: SessionSettings, progress: Progress = ignore_progress
) -> Comparison:
    """Read recordings and compute their deviations from the model.

    Args:
        protocol: the protocol that was recorded.
        takes: files by run.
        settings: trunk, axes, model and registration.
        progress: called as the work goes on.

    Raises:
        TakeError: for recordings that cannot be read or do not match the protocol.
        ModelError: for a trunk that the model cannot compute.
    """
    session = build_session(protocol, takes, settings, progress)
    deviations = tuple(
        compute_deviation(run.points, run.predicted.points, run.rotation, run.predicted.rotation)
        for run in session.runs
    )
    return Comparison(protocol=protocol, settings=settings, session=session, deviations=deviations)


def compute_result(comparison: Comparison, files: Sequence[str] = ()) -> dict[str, Any]:
    """All figures, ready for JSON."""
    settings, session, runs = comparison.settings, comparison.session, comparison.session.runs
    friction = settings.design.cable.friction if settings.friction is None else settings.friction
    count = len(session.synthetic)
    what = "1 recording is synthetic" if count == 1 else f"{count} recordings are synthetic"
    warnings = [f"not a measurement: {what}, such as {first}" for first in session.synthetic[:1]]
    result = {
        "model": settings.model,
        "friction": None if settings.model == "reference" else friction,
        "design": settings.design.name,
        "protocol": comparison.protocol.name,
        "axes": settings.axes or comparison.protocol.axes,
        "alignment": str(session.alignment),
        "is_made_up": bool(session.synthetic),
        "runs": {
            run.schedule.run.name: _summarise_run(run, deviation)
            for run, deviation in zip(runs, comparison.deviations, strict=True)
        },
        "mean_rmse_by_alignment_m": {
            str(alignment): {run.schedule.run.name: _compute_aligned_rmse(run, alignment) for run in runs}
            for alignment in dict.fromkeys([*(Alignment(kind=kind) for kind in ALIGNMENTS), session.alignment])
        },
        "paper": PAPER,
        "notes": [*warnings, *(note for run in runs for note in run.notes)],
        "versions": read_versions("numpy"),
        "files": files,
    }
    return dict(to_json(result))


def _summarise_run(run: RunShapes, deviation: Deviation) -> dict[str, Any]:
    sections = deviation.sections
    return {
        "kind": run.schedule.run.kind,
        "tilt_deg": compute_tilt_deg(run),
        "shapes": len(run.points),
        "sections": sections,
        "rmse_per_shape_m": deviation.per_shape,
        "rmse_per_section_m": deviation.per_section[np.array(sections) - 1],
        "mean_rmse_m": deviation.mean_rmse,
        "max_rmse_m": deviation.max_rmse,
        "max_deviation_m": deviation.max_deviation,
        "mean_turn_deg": math.degrees(deviation.mean_turn),
        "spread_of_takes_m": run.spread,
        "takes": [
            {
                "file": take.take.source,
                "name": take.take.name,
                "recorded": take.take.started,
                "times_s": [[held.begin, held.end] for held in take.held],
            }
            for take in run.takes
        ],
    }


def compute_tilt_deg(run: RunShapes) -> float:
    """Tilt of the base from hanging [deg]."""
    return round(90.0 - math.degrees(run.schedule.run.theta_0), 9) + 0.0


def _compute_aligned_rmse(run: RunShapes, alignment: Alignment) -> float | None:
    """Mean RMSE of a run registered by another alignment; None where that alignment is impossible [m]."""
    try:
        points, _, _ = register(run.schedule.run, run.predicted, run.takes, alignment)
    except TakeError:
        return None
    return compute_deviation(average_takes(points), run.predicted.points).mean_rmse
