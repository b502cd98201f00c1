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
"""Supports of an object: strings, or the ground."""

STANCES = ("lying", "upright")
"""Orientations of an object's axis on the ground."""

TIMESTEP = 1e-3
"""Step of the physics [s]."""


@final
@dataclass(frozen=True, kw_only=True)
class SceneOptions:
    """Scene of a trial: its true state, and the state announced to the robot."""

    shape: ObjectSpec = field(default_factory=lambda: parse_object(DEFAULT_OBJECT))
    """The true object."""
    announced: ObjectSpec | None = None
    """The object as announced to the robot; None announces the true one."""
    stage: str = "hung"
    """Support of the object: "hung" on two strings, or on the "ground"."""
    stance: str = "lying"
    """Orientation: "lying", its axis horizontal, or "upright"; hung objects are lying."""
    yaw: float = 0.0
    """Announced angle of its axis about the vertical from the world's x [rad]."""
    yaw_error: float = 0.0
    """True minus announced angle [rad]."""
    ground: float = 0.60
    """Height of the ground [m], reachable from above and from the side."""
    position: tuple[float, float, float] = (0.45, 0.10, 0.85)
    """Announced centre of the object, shape (3,) [m]; on the ground, its height follows from the object."""
    offset: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """True minus announced centre, shape (3,) [m]."""
    aside: float = 0.20
    """Carry along y, not 0 [m]."""
    lift: float = 0.20
    """Height to lift by, above 0 [m]."""
    push: tuple[float, float] = (0.0, 0.0)
    """Displacement by which it is to be pushed on the ground (x, y) [m]; zero where it is to be lifted."""
    place_aside: float = 0.35
    """Distance of the table's middle along y from the hung object [m], clear of the curling trunk."""
    place_rise: float = 0.08
    """Height of the target above the object's start [m]; the strings are slack there."""
    trunk: TrunkOptions = field(default_factory=TrunkOptions)
    """Options of the simulated trunk."""
    sensors: SensorOptions = field(default_factory=SensorOptions)
    """Errors of sensors and commands."""
    friction_hardness: float = 1.0
    """Ratio of friction to normal stiffness in contacts, MuJoCo's impratio [-]: soft friction lets objects creep."""
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
            raise DesignError("scene.stance", got=self.stance, allowed='"lying" for a hung object')
        if self.aside == 0:
            raise DesignError("scene.aside", got=self.aside, allowed="any distance but 0")
        for name, count in (("position", 3), ("offset", 3), ("push", 2)):
            check_numbers(f"scene.{name}", getattr(self, name), count=count)
            for i, value in enumerate(getattr(self, name)):
                check_number(f"scene.{name}[{i}]", value, above=-3.0, below=3.0)
        if self.stage == "hung" and any(self.push):
            raise DesignError("scene.push", got=self.push, allowed="(0, 0) for a hung object")
        check_type("scene.shape", self.shape, ObjectSpec)
        if self.announced is not None:
            check_type("scene.announced", self.announced, ObjectSpec)
        check_type("scene.trunk", self.trunk, TrunkOptions)
        check_type("scene.sensors", self.sensors, SensorOptions)
