"""Options of a scene: object, support, sensors and trunk."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import final

from spiraltrunk.checks import check_number
from spiraltrunk.errors import DesignError, UnknownName
from spiraltrunk.field_docs import explain_fields
from spiraltrunk.sim.objects.catalogue import DEFAULT_OBJECT, ObjectSpec, parse_object
from spiraltrunk.sim.robot.trunk import TrunkOptions
from spiraltrunk.sim.sensors import SensorOptions

SUPPORTS = ("hung", "ground")
"""Supports of an object: two strings, or the ground."""

ORIENTATIONS = ("lying", "upright")
"""Orientations of an object on the ground: axis horizontal, or vertical."""

TIMESTEP = 2e-3
"""Time step of the physics, unless a scene has another [s] (ours): rates of success are those of shorter steps."""

TIMESTEP_LEAST, TIMESTEP_MOST = 1e-4, 2.5e-3
"""Shortest and longest time step of a scene [s] (ours): contacts are 4 ms soft, and at least two steps."""

EXTREMES_PERIOD = 0.01
"""Sampling period of contacts and joint bends, a whole number of time steps [s]."""

LIFT = 0.20
"""Height of the lift [m]."""

ASIDE = 0.20
"""Distance of the transport along y [m]."""

PLACE_ASIDE, PLACE_RISE = 0.35, 0.08
"""Place on the table relative to the hanging object: along y, clear of the trunk, and up, with slack strings [m]."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class SceneOptions:
    """The scene of one trial: its true state, and the state announced to the robot."""

    shape: ObjectSpec = field(default_factory=lambda: parse_object(DEFAULT_OBJECT))
    """The true object."""
    announced: ObjectSpec | None = None
    """The object as announced to the robot; None announces the true one."""
    support: str = "hung"
    """Support of the object: "hung" on two strings, or the "ground"."""
    orientation: str = "lying"
    """Orientation of the object: "lying", its axis horizontal, or "upright"; a hung object is lying."""
    yaw: float = 0.0
    """Announced yaw of the object's axis from the world's x [rad]."""
    yaw_error: float = 0.0
    """True minus announced yaw [rad]."""
    ground: float = 0.60
    """Height of the ground [m]; at the default, arm and trunk reach it from above and from the side."""
    position: tuple[float, float, float] = (0.45, 0.10, 0.85)
    """Announced centre of the object, shape (3,) [m]; on the ground, the height follows from the object."""
    offset: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """True minus announced centre, shape (3,) [m]."""
    push: tuple[float, float] = (0.0, 0.0)
    """Displacement (x, y) by which the object shall be pushed on the ground [m]; 0 where it shall be lifted."""
    trunk: TrunkOptions = field(default_factory=TrunkOptions)
    """Simulation options of the trunk."""
    sensors: SensorOptions = field(default_factory=SensorOptions)
    """Errors and delays of sensors and commands."""
    friction_hardness: float = 1.0
    """Impedance of friction over that of the contact, MuJoCo's ``impratio`` [-]; a low one lets held objects creep."""
    timestep: float = TIMESTEP
    """Time step of the physics [s]; contacts and limits are no faster than two steps, MuJoCo's own floor."""

    def __post_init__(self) -> None:
        for name, known in (("support", SUPPORTS), ("orientation", ORIENTATIONS)):
            if getattr(self, name) not in known:
                raise UnknownName(name, getattr(self, name), known)
        if self.support == "hung" and self.orientation != "lying":
            raise DesignError("scene.orientation", got=self.orientation, allowed='"lying" for a hung object')
        if self.support == "hung" and any(self.push):
            raise DesignError("scene.push", got=self.push, allowed="(0, 0) for a hung object")
        check_timestep("scene.timestep", self.timestep)


def check_timestep(name: str, value: object) -> None:
    """Refuse anything but a time step of which a whole number makes `EXTREMES_PERIOD`.

    Raises:
        DesignError: with the name, the value [s] and what is allowed.
    """
    check_number(name, value, least=TIMESTEP_LEAST, most=TIMESTEP_MOST)
    steps = EXTREMES_PERIOD / float(value)  # type: ignore[arg-type]
    if abs(steps - round(steps)) > 1e-9 * steps:
        allowed = f"{EXTREMES_PERIOD:g} s over a whole number, such as 0.0005, 0.001 or 0.002"
        raise DesignError(name, got=value, allowed=allowed)
