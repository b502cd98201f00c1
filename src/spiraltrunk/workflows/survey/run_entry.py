"""One trial of a survey, from its entry to its row."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import groupby

from spiraltrunk.control.strategy import Status
from spiraltrunk.design import presets
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.files.results import to_json
from spiraltrunk.processes.worker import format_error
from spiraltrunk.sim.objects.catalogue import parse_object
from spiraltrunk.sim.scene.options import TIMESTEP
from spiraltrunk.workflows.grasp.choice.auto import get_strategy
from spiraltrunk.workflows.grasp.trial import Trial, run_scene
from spiraltrunk.workflows.grasp.verdict.cause import find_error_cause
from spiraltrunk.workflows.grasp.world import draw_scene
from spiraltrunk.workflows.survey.plan import Entry
from spiraltrunk.workflows.survey.row import Row, build_empty_row


def compute_row(
    entry: Entry,
    design: TrunkDesign = presets.PAPER,
    timestep: float = TIMESTEP,
    *,
    run: Callable[..., Trial] | None = None,
) -> Row:
    """Run a trial with a robot, the paper's unless given; an exception in it is a failure with that reason.

    ``spiraltrunk grasp`` runs the same trial for the same design, strategy, object, seed and time step [s]. ``run`` is
    called as `run_scene`, which it replaces where the trial is recorded.

    Raises:
        ImportError: where a package is missing, which is no failure of the strategy.
    """
    began = time.perf_counter()
    row = build_empty_row(entry)
    try:
        shape = parse_object(entry.object)
        strategy = get_strategy(entry.strategy, design, shape)
        scene = replace(draw_scene(shape, entry.seed, strategy=strategy), timestep=timestep)
        row["width_m"], row["mass_kg"], row["friction"] = scene.shape.width, scene.shape.mass, scene.shape.friction
        row["stiffness_factor"] = scene.trunk.stiffness_factor
        row |= _summarise((run or run_scene)(design, scene, strategy=strategy, seed=entry.seed), strategy.job)
    except ImportError:
        raise
    except Exception as error:
        row["reason"], row["cause"] = format_error(error), find_error_cause(error).value
    return row | {"wall_s": time.perf_counter() - began}


def count_retries(statuses: Sequence[Status]) -> int:
    """How often a step of the prehension was repeated after another step."""
    steps = [action for (phase, action), _ in groupby((s.phase, s.action) for s in statuses) if phase == "prehension"]
    return max((steps.count(step) - 1 for step in steps), default=0)


def _summarise(trial: Trial, job: str) -> Row:
    verdict, holds = trial.verdict, job != "kick"
    figures = {
        "success": bool(verdict.success),
        "reason": verdict.reason,
        "cause": None if verdict.failure is None else verdict.failure.cause.value,
        "cause_time_s": None if verdict.failure is None else float(verdict.failure.time),
        "held": bool(verdict.is_held) if holds else None,
        "upright": verdict.is_upright if holds else None,
        "simulated_s": float(trial.plant.trace[-1].time),
        "real_time_factor": float(trial.real_time_factor),
        "planning_wall_s": float(trial.log.planning),
        "lift_m": float(verdict.lift),
        "hold_s": float(verdict.hold),
        "place_error_m": float(verdict.place_error),
        "retries": count_retries(trial.log.statuses),
    }
    return dict(to_json(figures))
