"""One trial in simulation: a world drawn from a seed, a strategy, and the verdict."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, final

from spiraltrunk import strategies
from spiraltrunk.control.loop import RunLog, run
from spiraltrunk.control.messages import Observation
from spiraltrunk.control.strategy import Status, Strategy
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.sim.mujoco_log import quiet_mujoco
from spiraltrunk.sim.objects.catalogue import ObjectSpec
from spiraltrunk.sim.plant import SimPlant
from spiraltrunk.sim.scene.options import SceneOptions
from spiraltrunk.workflows.grasp.jobs import JOBS
from spiraltrunk.workflows.grasp.verdict import Evidence, Moments, Verdict
from spiraltrunk.workflows.grasp.world import Spread, draw_scene


@final
@dataclass(frozen=True, kw_only=True)
class Trial:
    """A trial that has run."""

    strategy: str
    """Name of the strategy."""
    seed: int
    """Seed that the world was drawn from."""
    options: SceneOptions
    """The world."""
    plant: SimPlant
    """The simulator after the trial, with its record."""
    log: RunLog
    """What went between plant and strategy."""
    verdict: Verdict
    """What came of it."""
    real_time_factor: float
    """Simulated time over the time that the loop took on one core, Python included [-]."""


def run_trial(
    design: TrunkDesign,
    shape: ObjectSpec,
    *,
    strategy: str | Strategy[Any] = "wrap-vertical",
    seed: int = 0,
    spread: Spread | None = None,
    watch: Callable[[Observation, Status], None] | None = None,
) -> Trial:
    """Draw a world, run a strategy in it, by its name or one of your own, and evaluate the run by the strategy's job.

    ``spread`` says how far worlds differ; ``watch`` is called after every step.

    Raises:
        UnknownName: for a strategy that does not exist.
        DesignError: for anything but a design, an object, a seed and a spread.
        ModelError: where the strategy cannot plan for the object.
        RunError: where the simulation diverges or does not end.
    """
    chosen = strategies.get(strategy) if isinstance(strategy, str) else strategy
    options = draw_scene(shape, seed, strategy=chosen, spread=spread)
    return run_scene(design, options, strategy=chosen, seed=seed, watch=watch)


def run_scene(
    design: TrunkDesign,
    options: SceneOptions,
    *,
    strategy: Strategy[Any],
    seed: int,
    watch: Callable[[Observation, Status], None] | None = None,
) -> Trial:
    """Run a strategy in a scene that `draw_scene` drew from ``seed``, and evaluate the outcome.

    Raises:
        ModelError: where the strategy cannot plan for the object.
        RunError: where the simulation diverges or does not end.
    """
    plant = SimPlant(design, options)
    began = time.perf_counter()
    with quiet_mujoco():
        log = run(plant, strategy, watch=watch)
    factor = plant.trace[-1].time / (time.perf_counter() - began)
    evidence = Evidence(
        trace=plant.trace, task=plant.task, moments=Moments.from_log(log), gave_up=log.gave_up,
        warnings=plant.warnings, limits=plant.arm_limits,
    )  # fmt: skip
    return Trial(
        strategy=strategy.name, seed=seed, options=options, plant=plant, log=log,
        verdict=JOBS[strategy.job](evidence), real_time_factor=factor,
    )  # fmt: skip
