"""Options of the relaxation of a trunk in MuJoCo."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import final

from spiraltrunk.sim.robot.trunk import TrunkOptions


@final
@dataclass(frozen=True, kw_only=True)
class RelaxationOptions:
    """How the trunk is loaded and brought to rest, and what of it is simulated."""

    timestep: float = 1e-3
    """Step of the physics [s]."""
    pull_speed: float = 0.005
    """Speed of the winders, infinity for a step [m/s]. With friction the final shape depends on it, by 0.3 mm at this
    speed and 2 mm at 0.02 (ours, friction 0.15); without friction it does not."""
    has_smooth_ramps: bool = False
    """Whether winders follow the minimum-jerk polynomial at the same mean speed: abrupt starts and stops excite
    oscillations, which release sticking cables."""
    tension_speed: float = 1.0
    """Rate of change of tensions, infinity for a step [N/s]."""
    damping_factor: float = 3.0
    """Joint damping over the design's [-]; it affects the time to rest, not the shape."""
    brake_factor: float = 1.0
    """Further factor of joint damping while winders turn, and until no hinge is faster than 1000 times ``still`` [-];
    high values suppress the effect of inertia on which of several equilibria is reached."""
    armature_factor: float = 1.0
    """Armature of the joints over that of the simulation [-]; it affects the time to rest, not the shape."""
    limit_factor: float = 1.0
    """Stiffness of the joint limits over that of the simulation [-]. Steps of 1 ms are stable up to 1000 with a
    hundredfold armature."""
    still: float = 1e-5
    """Largest speed of a hinge at rest [rad/s]."""
    time_most: float = 60.0
    """Largest time from the end of a ramp to rest [s]."""
    has_gripper: bool = True
    """Whether the tip carries the gripper's mass, its fingers straight and rigid."""
    has_contact: bool = False
    """Whether the trunk's sections collide; the equilibrium models have joint limits only."""
    trunk: TrunkOptions = field(default_factory=TrunkOptions)
    """Options of the simulated trunk."""
