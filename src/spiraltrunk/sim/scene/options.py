"""Options of a scene: stage, object, sensors, actuators and time step."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import final

from spiraltrunk.checks import check_number, check_numbers, check_type
from spiraltrunk.errors import DesignError, UnknownName
from spiraltrunk.sim.objects.catalogue import DEFAULT_OBJECT, ObjectSpec, parse_object
from spiraltrunk.sim.robot.trunk import TrunkOptions
from spiraltrunk.sim.sensors import SensorOptions

STAGES = ("hung", "ground")
"""What an object may rest on: strings, or the ground."""

STANCES = ("lying", "upright")
"""How the axis of an object may stand on the ground."""

TIMESTEP = 1e-3
"""Step of the physics [s]."""


@final
@dataclass(frozen=True, kw_only=True)
class SceneOptions:
    """One trial's world: what is known to the robot, and how the truth differs from it."""

    shape: ObjectSpec = field(default_factory=lambda: parse_object(DEFAULT_OBJECT))
    """The object as it truly is."""
    told: ObjectSpec | None = None
    """The object as the robot is told of it; None tells the truth."""
    stage: str = "hung"
    """What the object rests on: "hung" on two strings, or on the "ground"."""
    stance: str = "lying"
    """How it rests: "lying", its axis horizontal, or "upright"; what hangs, lies."""
    yaw: float = 0.0
    """Turn of its axis about the vertical from the world's x, as the robot is told [rad]."""
    yaw_error: float = 0.0
    """True turn minus the one that is told [rad]."""
    ground: float = 0.60
    """Height of the ground [m]: where arm and trunk reach it both from above and from the side."""
    position: tuple[float, float, float] = (0.45, 0.10, 0.85)
    """Nominal centre of the object, shape (3,) [m]; on the ground, its height follows from the object."""
    offset: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """True centre minus nominal, unknown to the robot, shape (3,) [m]."""
    aside: float = 0.20
    """Carry along y, not 0 [m]."""
    lift: float = 0.20
    """Height to lift by, above 0 [m]."""
    push: tuple[float, float] = (0.0, 0.0)
    """Way from where it lies on the ground to where it shall be pushed (x, y) [m]; none where it shall be lifted."""
    place_aside: float = 0.35
    """Distance of the table's middle along y from where the object hangs [m]: clear of the curling trunk."""
    place_rise: float = 0.08
    """Height of the place to set down above the object's start [m]; the strings stay slack there."""
    trunk: TrunkOptions = field(default_factory=TrunkOptions)
    """The trunk's simulation."""
    sensors: SensorOptions = field(default_factory=SensorOptions)
    """What the robot reads wrongly, and when."""
    friction_hardness: float = 1.0
    """How much harder friction is than the contact that it acts in [-]: what soft friction holds creeps out."""
    timestep: float = TIMESTEP
    """Step of the physics [s]."""

    def __post_init__(self) -> None:
        for name in ("aside", "place_aside", "place_rise"):
            check_number(f"scene.{name}", getattr(self, name), above=-1.0, below=1.0)
        check_number("scene.lift", self.lift, above=0.0, below=1.0)
        check_number("scene.ground", self.ground, above=0.0, below=2.0)
        check_number("scene.friction_hardness", self.friction_hardness, above=0.0, below=1e3)
        check_number("scene.timestep", self.timestep, above=0.0, below=0.0101)
        for name in ("yaw", "yaw_error"):
            check_number(f"scene.{name}", getattr(self, name), above=-7.0, below=7.0)
        if self.stage not in STAGES:
            raise UnknownName("stage", self.stage, STAGES)
        if self.stance not in STANCES:
            raise UnknownName("stance", self.stance, STANCES)
        if self.stage == "hung" and self.stance != "lying":
            raise DesignError("scene.stance", got=self.stance, allowed='"lying", as what hangs, lies')
        if self.aside == 0:
            raise DesignError("scene.aside", got=self.aside, allowed="any distance but 0")
        for name, count in (("position", 3), ("offset", 3), ("push", 2)):
            check_numbers(f"scene.{name}", getattr(self, name), count=count)
            for i, value in enumerate(getattr(self, name)):
                check_number(f"scene.{name}[{i}]", value, above=-3.0, below=3.0)
        if self.stage == "hung" and any(self.push):
            raise DesignError("scene.push", got=self.push, allowed="(0, 0), as what hangs is lifted")
        check_type("scene.shape", self.shape, ObjectSpec)
        if self.told is not None:
            check_type("scene.told", self.told, ObjectSpec)
        check_type("scene.trunk", self.trunk, TrunkOptions)
        check_type("scene.sensors", self.sensors, SensorOptions)
