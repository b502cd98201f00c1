"""The work of a survey: one trial, run and told."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from itertools import groupby

from spiraltrunk import strategies
from spiraltrunk.control.strategy import Status
from spiraltrunk.design import presets
from spiraltrunk.sim.objects.catalogue import parse_object
from spiraltrunk.workflows.grasp.trial import Trial, run_trial
from spiraltrunk.workflows.grasp.world import draw_scene
from spiraltrunk.workflows.survey.plan import Entry
from spiraltrunk.workflows.survey.process_pool import tell_error
from spiraltrunk.workflows.survey.row import WORLD, Row, build_empty_row


def compute_row(entry: Entry) -> Row:
    """Run a trial with the paper's robot; what is raised in it is a failure with that reason.

    It is the trial of ``spiraltrunk grasp`` with the same strategy, object and seed.
    """
    began = time.perf_counter()
    row = build_empty_row(entry)
    try:
        shape = parse_object(entry.object)
        world = draw_scene(shape, entry.seed, strategy=strategies.get(entry.strategy))
        drawn = (world.shape.width, world.shape.mass, world.shape.friction, world.trunk.stiffness_factor)
        row |= zip(WORLD, drawn, strict=True)
        trial = run_trial(presets.PAPER, shape, strategy=entry.strategy, seed=entry.seed)
        row |= _tell(trial)
    except Exception as error:
        row["reason"] = tell_error(error)
    return row | {"wall_s": time.perf_counter() - began}


def count_retries(statuses: Sequence[Status]) -> int:
    """How often a step of the prehension was begun again after another one."""
    steps = [action for (phase, action), _ in groupby((s.phase, s.action) for s in statuses) if phase == "prehension"]
    return max((steps.count(step) - 1 for step in steps), default=0)


def _tell(trial: Trial) -> Row:
    verdict = trial.verdict
    return {
        "success": bool(verdict.success),
        "reason": verdict.reason,
        "simulated_s": _finite(trial.plant.trace[-1].time),
        "real_time_factor": _finite(trial.real_time_factor),
        "planning_wall_s": _finite(trial.log.planning),
        "lift_m": _finite(verdict.lift),
        "hold_s": _finite(verdict.hold),
        "place_error_m": _finite(verdict.place_error),
        "retries": count_retries(trial.log.statuses),
    }


def _finite(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None
