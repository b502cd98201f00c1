"""Worlds of environments: drawn as trials of the survey are, from an object, a strategy's scene and a seed."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any, final

import numpy as np

from spiraltrunk.control.messages import Task
from spiraltrunk.control.strategy import Strategy
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import DesignError, ModelError, UnknownName
from spiraltrunk.field_docs import explain_fields
from spiraltrunk.sim.objects.catalogue import parse_object
from spiraltrunk.sim.scene.options import TIMESTEP, SceneOptions
from spiraltrunk.workflows.grasp.choice.auto import get_strategy, list_objects
from spiraltrunk.workflows.grasp.choice.ground import set_ground
from spiraltrunk.workflows.grasp.world import Spread, draw_scene

EVERYDAY = "everyday"
"""Object that is drawn anew for each world: ``everyday:seed=N``."""

EVERYDAY_SEEDS = 100_000
"""Seeds that are drawn for it, from 0 [-] (ours)."""

SEEDS = 2**32
"""Seeds of worlds, from 0 [-]."""

OPTIONS = ("object", "seed_world", "strategy")
"""What `reset` takes in its options."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class WorldKey:
    """What a world is drawn from."""

    object: str
    """Name of the object, or its measures as a text."""
    seed_world: int
    """Seed of the world: that of a trial of the survey."""
    strategy: str
    """Name of the strategy whose scene it is."""


@final
@dataclass(frozen=True, kw_only=True)
class World:
    """A world that was drawn."""

    key: WorldKey
    """What it was drawn from."""
    scene: SceneOptions
    """The scene."""


def draw_key(
    generator: np.random.Generator, objects: Sequence[str], strategy: str, options: Mapping[str, Any] | None
) -> WorldKey:
    """Draw the key of the next world; values in ``options`` of `reset` take precedence.

    The random generator advances alike with and without them.

    Raises:
        UnknownName: for an option that does not exist.
        DesignError: for a seed that is none, and options that are no mapping.
    """
    if options is not None and not isinstance(options, Mapping):
        raise DesignError("options", got=options, allowed="a mapping, such as {'object': 'box-80', 'seed_world': 5}")
    given = dict(options or {})
    for name in given:
        if name not in OPTIONS:
            raise UnknownName("option of reset", str(name), OPTIONS)
    chosen = objects[int(generator.integers(len(objects)))]
    number, seed = int(generator.integers(EVERYDAY_SEEDS)), int(generator.integers(SEEDS))
    chosen = given.get("object", chosen)
    seed = given.get("seed_world", seed)
    if not isinstance(seed, (int, np.integer)) or isinstance(seed, bool) or not 0 <= seed < SEEDS:
        raise DesignError("options['seed_world']", got=seed, allowed=f"a whole number from 0 to {SEEDS - 1}")
    return WorldKey(
        object=f"{EVERYDAY}:seed={number}" if chosen == EVERYDAY else chosen, seed_world=int(seed),
        strategy=given.get("strategy", strategy),
    )  # fmt: skip


def draw_world(
    key: WorldKey,
    design: TrunkDesign,
    *,
    job: str,
    stage: str,
    spread: Spread,
    has_camera: bool | None = None,
    timestep: float = TIMESTEP,
) -> World:
    """The world of a key.

    With the survey's spread and camera, it is the scene of the survey's trial with the same object, seed and strategy.
    The ground is the usual one where the strategy has no plan for the object, or where the arm reaches high enough over
    no ground.

    Args:
        key: object, seed and strategy.
        design: the robot.
        job: the environment's, which the strategy must have.
        stage: the environment's, which the strategy must have.
        spread: how far worlds differ.
        has_camera: whether a camera observes the object; None leaves it to the strategy.
        timestep: time step of the physics [s].

    Raises:
        UnknownName: for an object or strategy that does not exist.
        DesignError: for an object that cannot be read, and a strategy of another job or stage.
    """
    shape = parse_object(key.object)
    strategy = get_strategy(key.strategy, design, shape, stage)
    _check_job(strategy, job, stage)
    scene = replace(draw_scene(shape, key.seed_world, strategy=strategy, spread=spread), timestep=timestep)
    if has_camera is not None and has_camera != scene.sensors.has_camera:
        scene = replace(scene, sensors=replace(scene.sensors, has_camera=has_camera))
    with suppress(ModelError):
        scene = set_ground(design, scene, strategy)
    return World(key=key, scene=scene)


def describe_world(world: World) -> dict[str, Any]:
    """The world in plain values: what it was drawn from, and what is true and what is announced."""
    scene, true = world.scene, world.scene.shape
    announced = scene.announced or true
    x, y, z = (float(value) for value in scene.position)
    dx, dy, dz = (float(value) for value in scene.offset)
    return {
        "object": world.key.object, "seed_world": world.key.seed_world, "strategy": world.key.strategy,
        "support": scene.support, "orientation": scene.orientation, "kind": true.kind,
        "mass_kg": float(true.mass), "friction": float(true.friction),
        "length_m": float(true.length), "width_m": float(true.width),
        "size_factor": float(true.length / announced.length), "mass_factor": float(true.mass / announced.mass),
        "stiffness_factor": float(scene.trunk.stiffness_factor), "yaw_rad": float(scene.yaw),
        "yaw_error_rad": float(scene.yaw_error), "position_m": (x, y, z), "offset_m": (dx, dy, dz),
        "ground_m": float(scene.ground), "delay_s": float(scene.sensors.delay),
        "has_camera": bool(scene.sensors.has_camera),
    }  # fmt: skip


def read_objects(given: str | Sequence[str] | None, strategy: str) -> tuple[str, ...]:
    """Objects of which one is drawn for each world; None takes the first one that the strategy is meant for.

    Raises:
        UnknownName: for a strategy that does not exist.
        DesignError: for anything but texts.
    """
    if given is None:
        return list_objects(strategy)[:1]
    objects = (given,) if isinstance(given, str) or not isinstance(given, Iterable) else tuple(given)
    if not objects or not all(isinstance(each, str) for each in objects):
        raise DesignError("object", got=given, allowed="a text, or one or more texts")
    for each in objects:
        if each != EVERYDAY:
            parse_object(each)  # Refuses now what it would refuse at a reset.
    return objects


def check_strategy(name: str, design: TrunkDesign, job: str, stage: str) -> None:
    """Refuse a strategy of another job or stage than an environment's.

    Raises:
        UnknownName: for a strategy that does not exist.
        DesignError: with what is allowed.
    """
    _check_job(get_strategy(name, design, parse_object(list_objects(name)[0]), stage), job, stage)


def describe_task(task: Task, job: str) -> str:
    """A task in one sentence."""
    target, goal = task.target, task.goal
    what = f"the {target.kind} of {1e3 * target.width:.0f} mm"
    way = 1e2 * float(np.linalg.norm((goal.place - target.position)[:2]))
    if job == "kick":
        return f"kick {what} {way:.0f} cm along the ground with the spiral trunk"
    aside = 1e2 * float(np.linalg.norm(goal.aside))
    grasp = (
        f"lift it by {1e2 * goal.lift:.0f} cm, carry it {aside:.0f} cm aside, hold it for {goal.hold:g} s, set it down "
        "and let go"
    )
    if job == "sweep":
        return f"sweep {what} {way:.0f} cm along the ground with the spiral trunk, then {grasp}"
    return f"grasp {what} with the spiral trunk, {grasp}"


def _check_job(strategy: Strategy[Any], job: str, stage: str) -> None:
    if strategy.job != job or strategy.support != stage:
        allowed = f"one whose job is a {job} with the support {stage!r}"
        raise DesignError("strategy", got=strategy.name, allowed=allowed)
