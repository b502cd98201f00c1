"""Options of a scene: stage, object, sensors, actuators and time step."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import final

from spiraltrunk.checks import check_number
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
        for name, value, known in (("stage", self.stage, STAGES), ("stance", self.stance, STANCES)):
            if value not in known:
                raise UnknownName(name, value, known)
        if self.stage == "hung" and self.stance != "lying":
            raise DesignError("scene.stance", got=self.stance, allowed='"lying" for a hung object')
        if self.stage == "hung" and any(self.push):
            raise DesignError("scene.push", got=self.push, allowed="(0, 0) for a hung object")
        check_number("scene.lift", self.lift, above=0.0)
        check_number("scene.timestep", self.timestep, above=0.0, below=0.0101)
        if self.aside == 0 or math.isnan(self.aside):
            raise DesignError("scene.aside", got=self.aside, allowed="any distance but 0")
