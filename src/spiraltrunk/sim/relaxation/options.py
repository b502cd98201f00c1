"""Options of a relaxation: time step, speed of the winders, damping, criterion of rest."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import final

from spiraltrunk.sim.robot.trunk import TrunkOptions


@final
@dataclass(frozen=True, kw_only=True)
class RelaxationOptions:
    """Options of the dynamic relaxation of a trunk with a clamped base."""

    timestep: float = 1e-3
    """Time step of the physics [s]."""
    pull_speed: float = 0.005
    """Speed of the winders [m/s]; infinite for a jump. With friction the shape depends on it, by 0.3 mm at this speed
    and by 2 mm at 0.02 (ours, friction 0.15); without friction it does not."""
    has_smooth_ramps: bool = False
    """Whether winders follow a minimum-jerk polynomial of the same mean speed instead of a linear ramp. A sudden start
    or stop makes the trunk oscillate, which releases sticking cables."""
    tension_speed: float = 1.0
    """Rate of change of the tensions [N/s]; infinite for a jump."""
    damping_factor: float = 3.0
    """Joint damping over the design's [-]; changes the time to rest and not the equilibrium."""
    brake_factor: float = 1.0
    """Further factor of the joint damping while winders turn, and after it until every hinge is slower than 1000 times
    ``still`` [-]. A large factor removes the influence of inertia on which of several equilibria is reached."""
    armature_factor: float = 1.0
    """Armature of the joints over that of the grasp simulation [-]; changes the time to rest and not the
    equilibrium."""
    limit_factor: float = 1.0
    """Stiffness of the joint limits over that of the grasp simulation [-]; the overshoot is inversely proportional to
    it. At time steps of 1 ms, 1000 is stable with an armature factor of 100."""
    still: float = 1e-5
    """Rest criterion: largest speed of a hinge [rad/s]."""
    time_most: float = 60.0
    """Time limit for reaching rest after the end of a ramp [s]."""
    has_gripper: bool = True
    """Whether the tip carries the gripper's mass, with straight, rigid fingers."""
    trunk: TrunkOptions = field(default_factory=TrunkOptions)
    """Simulation options of the trunk."""
