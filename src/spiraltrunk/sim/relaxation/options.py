"""How a trunk is brought to rest in MuJoCo."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import final

from spiraltrunk.checks import check_number
from spiraltrunk.sim.robot.trunk import TrunkOptions


@final
@dataclass(frozen=True, kw_only=True)
class SettleOptions:
    """How the trunk is brought to rest, and what of it is simulated."""

    timestep: float = 1e-3
    """Step of the physics [s]."""
    pull_speed: float = 0.005
    """Speed of the winders, infinity for at once [m/s]; with friction the shape depends on it, by 0.3 mm at this one
    and 2 mm at 0.02 (ours, friction 0.15), without it not at all."""
    has_smooth_ramps: bool = False
    """Whether winders speed up and slow down along the polynomial of least jerk, at the same mean speed, instead of at
    once: what starts or stops abruptly swings the trunk, and a swing shakes sticking cables loose."""
    tension_speed: float = 1.0
    """Change of tension, infinity for at once [N/s]; likewise."""
    damping_factor: float = 3.0
    """Joint damping over the design's [-]; where the trunk rests does not depend on it, when does."""
    brake_factor: float = 1.0
    """Joint damping over that while winders turn, and after until no hinge is faster than 1000 times ``still`` [-];
    much of it leaves inertia no say in which of several shapes that balance the trunk comes to rest."""
    armature_factor: float = 1.0
    """Armature of the joints over that of the simulation [-]; likewise."""
    limit_factor: float = 1.0
    """Stiffness of the joint limits over that of the simulation [-]; joints end that much less past them. At 1 ms steps
    1000 are borne with a hundredfold armature."""
    still: float = 1e-5
    """Largest speed of a hinge that counts as rest [rad/s]."""
    time_most: float = 60.0
    """Time after the end of a ramp in which rest must come [s]."""
    has_gripper: bool = True
    """Whether the tip carries the gripper's mass, its fingers straight and stiff."""
    has_contact: bool = False
    """Whether the trunk's sections collide; the models of equilibrium know joint limits alone."""
    trunk: TrunkOptions = field(default_factory=TrunkOptions)
    """The trunk's simulation."""

    def __post_init__(self) -> None:
        check_number("timestep", self.timestep, above=0.0, below=0.01)
        for name in ("pull_speed", "tension_speed"):
            if getattr(self, name) != math.inf:
                check_number(name, getattr(self, name), above=0.0)
        for name in ("damping_factor", "brake_factor", "armature_factor"):
            check_number(name, getattr(self, name), least=0.0, below=1e6)
        check_number("limit_factor", self.limit_factor, above=0.0, below=1e6)
        check_number("still", self.still, above=0.0)
        check_number("time_most", self.time_most, above=0.0, below=1e4)
