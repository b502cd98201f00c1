"""One trial in simulation: a scene drawn from a seed, a strategy, and the verdict."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, final

from spiraltrunk.control.loop import RunLog, run
from spiraltrunk.control.messages import Observation
from spiraltrunk.control.strategy import Status, Strategy
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.field_docs import explain_fields
from spiraltrunk.sim.machine import SimMachine
from spiraltrunk.sim.mujoco_log import quiet_mujoco
from spiraltrunk.sim.objects.catalogue import ObjectSpec
from spiraltrunk.sim.plant import SimPlant
from spiraltrunk.sim.scene.options import TIMESTEP, SceneOptions
from spiraltrunk.workflows.grasp.choice.auto import get_strategy
from spiraltrunk.workflows.grasp.choice.ground import set_ground
from spiraltrunk.workflows.grasp.choice.last_try import evaluate
from spiraltrunk.workflows.grasp.verdict.grasp_verdict import Verdict
from spiraltrunk.workflows.grasp.world import AS_ANNOUNCED, Spread, draw_scene


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class Trial:
    """A trial that has run."""

    strategy: str
    """Name of the strategy."""
    seed: int
    """Seed from which the scene was drawn."""
    options: SceneOptions
    """Options of the scene."""
    plant: SimMachine
    """The simulated machine after the trial, with its trace."""
    log: RunLog
    """Messages between plant and strategy."""
    verdict: Verdict
    """Whether it succeeded, and why not."""
    real_time_factor: float
    """Simulated time over the time that the loop took on one core, Python included [-]."""


def run_trial(
    design: TrunkDesign,
    shape: ObjectSpec,
    *,
    strategy: str | Strategy[Any] = "wrap-vertical",
    stage: str | None = None,
    seed: int = 0,
    spread: Spread | None = None,
    timestep: float = TIMESTEP,
    watch: Callable[[Observation, Status], None] | None = None,
) -> Trial:
    """Draw a scene, run a strategy in it, by its name or one of your own, and evaluate the outcome.

    ``stage`` is for "auto", which chooses a strategy: "ground" by default, or "hung". ``spread`` says how far scenes
    differ; ``timestep`` is that of the physics [s]; ``watch`` is called after every step.

    Raises:
        UnknownName: for a strategy that does not exist.
        DesignError: for anything but a design, an object, a seed, a spread and a time step.
        ModelError: where the strategy cannot plan for the object.
        RunError: where the simulation diverges or does not end.
    """
    chosen = get_strategy(strategy, design, shape, stage) if isinstance(strategy, str) else strategy
    options = replace(draw_scene(shape, seed, strategy=chosen, spread=spread), timestep=timestep)
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

    Where the arm does not reach high enough over the scene's ground, the ground is lower: `choose_ground`.

    Raises:
        ModelError: where the strategy cannot plan for the object.
        RunError: where the simulation diverges or does not end.
    """
    plant = build_plant(design, options, strategy)
    return run_plant(plant, strategy, seed=seed, watch=watch)


def build_plant(design: TrunkDesign, options: SceneOptions, strategy: Strategy[Any]) -> SimPlant:
    """Simulated plant of a scene, over a ground on which the arm reaches high enough for the strategy.

    Raises:
        ModelError: where the strategy cannot plan for the object.
    """
    return SimPlant(design, set_ground(design, options, strategy))


def check_plan(design: TrunkDesign, shape: ObjectSpec, strategy: Strategy[Any]) -> None:
    """Plan for an object as it is announced, without a trial.

    Raises:
        ModelError: where the strategy cannot plan for the object.
    """
    plant = build_plant(design, draw_scene(shape, 0, strategy=strategy, spread=AS_ANNOUNCED), strategy)
    strategy.init(plant.reset())


def run_plant(
    plant: SimPlant,
    strategy: Strategy[Any],
    *,
    seed: int,
    watch: Callable[[Observation, Status], None] | None = None,
) -> Trial:
    """Run a strategy on a simulated plant, and evaluate the outcome; for those who look at the plant meanwhile.

    Raises:
        ModelError: where the strategy cannot plan for the object.
        RunError: where the simulation diverges or does not end.
    """
    began = time.perf_counter()
    with quiet_mujoco():
        log = run(plant, strategy, watch=watch)
    factor = plant.trace[-1].time / (time.perf_counter() - began)
    return Trial(
        strategy=strategy.name, seed=seed, options=plant.options, plant=plant, log=log,
        verdict=evaluate(plant, log, strategy.job), real_time_factor=factor,
    )  # fmt: skip
