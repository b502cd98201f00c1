"""Scenes of trials, drawn from a seed: object, position, friction, stiffness and sensor errors."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, final

import numpy as np

from spiraltrunk import strategies
from spiraltrunk.checks import check_number, check_numbers, check_text, check_type
from spiraltrunk.control.strategy import Strategy
from spiraltrunk.errors import DesignError
from spiraltrunk.field_docs import explain_fields
from spiraltrunk.sim.objects.catalogue import ObjectSpec, scaled
from spiraltrunk.sim.objects.presentation import present
from spiraltrunk.sim.objects.spec import EXTENTS, MASSES
from spiraltrunk.sim.robot.trunk import TrunkOptions
from spiraltrunk.sim.scene.options import SceneOptions
from spiraltrunk.sim.sensors import SensorOptions
from spiraltrunk.workflows.grasp.verdict.jobs import JOBS

NOISE = SensorOptions(
    pull_noise=0.2e-3, tension_noise=0.2, tension_share=0.02, torque_noise=0.02, delay=0.020, camera_error=0.003,
    camera_turn=math.radians(3.0),
)  # fmt: skip
"""Errors of the real robot's sensors (ours): cable lengths 0.2 mm, tensions from motor currents 0.2 N and 2 %, torques
of the arm 0.02 N m, commands 20 ms late, camera 3 mm and 3 deg."""

GRIP_FRICTION = 300.0
"""Hardness of friction (MuJoCo's ``impratio``) where fingers may hold (ours) [-]. Held objects creep, dry ones do not:
at 1, MuJoCo's own, a ball of 15 g out of a firm grip by 2 mm/s. Of 26 drawn objects that fingers take first
(`benchmarks/held_creep.py`) those that are held sink by 0.40 mm/s at 10, 0.25 at 30, 0.09 at 100, 0.037 at 300 and
0.019 at 1000 in the median, and 10, 16, 19, 19 and 20 trials succeed: 20 too with MuJoCo's second solver, which takes
this softness out. At 300 a step takes a fifth longer than at 30."""

WRAP_FRICTION = 10.0
"""The same in wraps (ours) [-]. At 1 a bottle of 70 mm creeps out by up to 15 mm/s and a wide cylinder tilts in its
loop; at 10 and at 30 bottles and cylinders shift equally little, by the trunk's compliance, and at 10 a step is a fifth
faster. Objects heavier than HEAVY creep more."""

LONG = 1.3
"""Length of a lying object over its width from which fingers grip it across its axis (ours) [-]."""

HEAVY = 1.0
"""Mass above which a wrapped object needs harder friction [kg]."""

HEAVY_FRICTION = 100.0
"""The same for objects heavier than HEAVY (ours) [-]: at 30, three of six of 1.5 kg tilt further and land askew, at 100
one of six."""

SLOPE_FRICTION = 300.0
"""The same for cones (ours) [-]: what narrows upwards loads friction by the grip itself, not by its weight alone. At 30
a cone of 35 mm creeps out of firm fingers by 0.65 mm/s, at 300 by 0.03 mm/s."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class Spread:
    """Ranges of a trial's random quantities, each drawn from a uniform distribution."""

    position: float = 0.030
    """Largest distance of the object's true position from the announced one, in any direction [m]."""
    yaw: float = math.radians(10.0)
    """Largest deviation of the object's yaw from the announced one [rad]."""
    size: float = 0.10
    """Largest relative deviation of the object's size from the announced one, within what objects may measure [-]."""
    mass: float = 0.20
    """Largest relative deviation of the object's mass from the announced one, within what objects may weigh [-]."""
    friction: tuple[float, float] = (0.5, 1.2)
    """Least and largest coefficient of friction between silicone and object [-]."""
    stiffness: float = 0.10
    """Largest relative deviation of the joints' stiffness from the design's [-]."""
    sensors: SensorOptions = NOISE
    """Errors of readings and commands."""

    def __post_init__(self) -> None:
        for name, below in (("position", 1.0), ("yaw", 7.0), ("size", 1.0), ("mass", 1.0), ("stiffness", 1.0)):
            check_number(f"spread.{name}", getattr(self, name), least=0.0, below=below)
        check_numbers("spread.friction", self.friction, count=2, above=0.0)
        if self.friction[0] > self.friction[1]:
            raise DesignError("spread.friction", got=self.friction, allowed="the smaller coefficient first")
        check_type("spread.sensors", self.sensors, SensorOptions)


AS_ANNOUNCED = Spread(
    position=0.0, yaw=0.0, size=0.0, mass=0.0, friction=(0.8, 0.8), stiffness=0.0, sensors=SensorOptions()
)  # fmt: skip
"""Everything as announced, sensors without error."""

EXACT = Spread(position=0.015, yaw=0.0, size=0.0, mass=0.0, sensors=SensorOptions())
"""Position within 15 mm, friction and stiffness unknown, everything else as announced, sensors without error."""


def draw_scene(
    shape: ObjectSpec, seed: int, *, strategy: Strategy[Any] | None = None, spread: Spread | None = None
) -> SceneOptions:
    """Scene for a strategy, drawn from ``seed``: its object and joints differ from what is announced to the robot.

    Raises:
        DesignError: for anything but an object, a seed, a strategy and a spread.
    """
    chosen = strategies.get("wrap-vertical") if strategy is None else strategy
    spread = Spread() if spread is None else spread
    check_type("spread", spread, Spread)
    if not isinstance(shape, ObjectSpec):
        raise DesignError("object", got=shape, allowed="an ObjectSpec, as parse_object makes of a name")
    if not isinstance(seed, (int, np.integer)) or isinstance(seed, bool) or seed < 0:
        raise DesignError("seed", got=seed, allowed="a whole number, at least 0")
    _check_strategy(chosen)
    orientation = chosen.orientation
    if chosen.support == "ground":
        orientation = _find_orientation(chosen, shape)
        shape = present(shape, orientation)
    rng = np.random.default_rng(seed)
    x, y, z = (float(value) for value in _draw_in_ball(rng, spread.position))
    friction = float(rng.uniform(*spread.friction))
    stiffness = float(rng.uniform(1 - spread.stiffness, 1 + spread.stiffness))
    size, mass = (float(rng.uniform(1 - part, 1 + part)) for part in (spread.size, spread.mass))
    yaw_error = float(rng.uniform(-1, 1)) * spread.yaw
    turned = float(rng.uniform(-math.pi / 2, math.pi / 2)) if chosen.support == "ground" and spread.yaw > 0 else 0.0
    sensors = replace(spread.sensors, has_camera=chosen.needs_camera, seed=int(rng.integers(2**32)))
    drawn = SceneOptions(
        shape=replace(_vary(shape, size, shape.mass * mass), friction=friction),
        announced=shape,
        support=chosen.support,
        orientation=orientation,
        yaw=turned,
        yaw_error=yaw_error,
        offset=(x, y, z),
        trunk=TrunkOptions(stiffness_factor=stiffness),
        sensors=sensors,
        push=chosen.push,
        friction_hardness=_hardness(chosen, shape),
    )
    return drawn if chosen.position is None else replace(drawn, position=(*chosen.position, drawn.position[2]))


def _vary(shape: ObjectSpec, factor: float, mass: float) -> ObjectSpec:
    """The object with sizes by ``factor`` and ``mass`` [kg], each as far as objects may have them."""
    inside = 1e-9  # Products are rounded.
    least, most = EXTENTS.least / min(shape.size) + inside, EXTENTS.below / max(shape.size) - inside
    factor = min(max(factor, least), most)
    return replace(scaled(shape, factor), mass=min(max(mass, MASSES.least), MASSES.below * (1 - inside)))


def _find_orientation(strategy: Strategy[Any], shape: ObjectSpec) -> str:
    """Orientation of the strategy's objects; fingers from above take a long object that lies as one that lies.

    Its axis is then announced and seen, across which they grip.
    """
    is_long = shape.up == "z" and shape.size[0] > LONG * shape.size[1]
    takes_it = strategy.job == "grasp" and strategy.holds == "fingers" and not strategy.has_fixed_orientation
    return "lying" if takes_it and is_long else strategy.orientation


def _check_strategy(strategy: Strategy[Any]) -> None:
    if not isinstance(strategy, Strategy):
        raise DesignError("strategy", got=strategy, allowed="a Strategy, as strategies.get makes of a name")
    check_text("strategy.name", getattr(strategy, "name", None))
    if strategy.job not in JOBS:
        raise DesignError("strategy.job", got=strategy.job, allowed=", ".join(JOBS))


def _hardness(strategy: Strategy[Any], shape: ObjectSpec) -> float:
    """Hardness of friction for a strategy and an object [-]; MuJoCo's own where nothing is held."""
    if strategy.holds == "nothing":
        return 1.0
    if shape.contact_kind == "cone":
        return SLOPE_FRICTION
    if strategy.holds == "fingers":
        return GRIP_FRICTION
    return HEAVY_FRICTION if shape.mass > HEAVY else WRAP_FRICTION


def _draw_in_ball(rng: np.random.Generator, radius: float) -> np.ndarray:
    """Point from a uniform distribution in a ball, shape (3,) [m]."""
    direction = rng.normal(size=3)
    return radius * float(rng.uniform()) ** (1 / 3) * direction / np.linalg.norm(direction)
