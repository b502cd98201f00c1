"""One trial in simulation: a world drawn from a seed, a strategy, and the verdict."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from spiraltrunk import strategies
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.plant import Observation
from spiraltrunk.run import RunLog, run
from spiraltrunk.sim.arm_spec import arm_limits
from spiraltrunk.sim.objects import ObjectSpec
from spiraltrunk.sim.plant import SimPlant
from spiraltrunk.sim.scene import SceneOptions
from spiraltrunk.sim.trunk_spec import TrunkOptions
from spiraltrunk.sim.verdict import Moments, Verdict, judge
from spiraltrunk.strategies.base import Status

PLACE_SPREAD = 0.015
"""Largest distance of the object's true place from the announced one, in any direction [m]."""

FRICTION_RANGE = (0.5, 1.2)
"""Coefficient of friction between silicone and object [-]."""

STIFFNESS_SPREAD = 0.10
"""Largest deviation of the joints' stiffness from the design's [-]."""


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


def draw_scene(shape: ObjectSpec, seed: int) -> SceneOptions:
    """A world whose object, friction and joints differ from what the robot is told, drawn from ``seed``."""
    rng = np.random.default_rng(seed)
    x, y, z = (float(value) for value in _draw_in_ball(rng, PLACE_SPREAD))
    friction = float(rng.uniform(*FRICTION_RANGE))
    stiffness = float(rng.uniform(1 - STIFFNESS_SPREAD, 1 + STIFFNESS_SPREAD))
    trunk = TrunkOptions(stiffness_factor=stiffness)
    return SceneOptions(shape=replace(shape, friction=friction), offset=(x, y, z), trunk=trunk)


def _draw_in_ball(rng: np.random.Generator, radius: float) -> np.ndarray:
    """A point evenly drawn in a ball, shape (3,) [m]."""
    direction = rng.normal(size=3)
    return radius * float(rng.uniform()) ** (1 / 3) * direction / np.linalg.norm(direction)


def run_trial(
    design: TrunkDesign,
    shape: ObjectSpec,
    *,
    strategy: str = "wrap-vertical",
    seed: int = 0,
    watch: Callable[[Observation, Status], None] | None = None,
) -> Trial:
    """Draw a world, run a strategy in it, and judge.

    Raises:
        UnknownName: for a strategy that does not exist.
        ModelError: where the strategy cannot plan for the object.
        RunError: where the simulation diverges or does not end.
    """
    chosen = strategies.get(strategy)
    options = draw_scene(shape, seed)
    plant = SimPlant(design, options)
    began = time.perf_counter()
    log = run(plant, chosen, watch=watch)
    factor = plant.trace[-1].time / (time.perf_counter() - began)
    return Trial(
        strategy=strategy, seed=seed, options=options, plant=plant, log=log, verdict=_judge(plant, log),
        real_time_factor=factor,
    )  # fmt: skip


def _judge(plant: SimPlant, log: RunLog) -> Verdict:
    moments = Moments(
        lift=log.span("transport", "lift"), carry=log.span("transport", "carry"), hold=log.span("transport", "hold")
    )
    limits = arm_limits(plant.design.arm)
    return judge(plant.trace, plant.task, moments, gave_up=log.gave_up, warnings=plant.warnings, limits=limits)
