"""Pushing an object along the ground to a place, steered by camera observations.

A single contact pushes unstably: an object a little beside the front's middle slides farther aside. So the rolled trunk
stays behind the object as seen from the place, moves no faster than the camera can follow, and slows down near the
place, where a ball then stops with it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import final

import numpy as np

from spiraltrunk.control.messages import Command, Observation
from spiraltrunk.strategies.push.approach_pose import ApproachPose
from spiraltrunk.strategies.sensing import seen_position

# All of these are ours, tuned in simulated trials with a camera that observes twice a second.
SPEED = 0.06
"""Greatest speed along the way [m/s]."""
SLOWEST = 0.012
"""Least speed along the way [m/s]."""
GAIN = 1.0
"""Speed over the distance left [1/s]: half of that distance passes between two observations."""
ASIDE = 0.04
"""Greatest speed across the way [m/s]."""
ASIDE_GAIN = 1.5
"""Speed across the way over the lateral error, free or behind a rolling object [1/s]."""
RECENTER = 0.2
"""The same behind a sliding object [1/s]: it sticks to the trunk and is carried along."""
TURN = 0.5
"""Largest lateral part of the object's wanted direction [-]: the contact stays near the front's middle."""
AGILITY = 6.0
"""Rate at which the speed follows the wanted one [1/s]."""
CONTACT_GAP = 0.02
"""Distance from the object below which the speed is limited by the distance left [m]."""
NEAR = 0.008
"""Distance left along the way that ends the push [m]."""
PASSED = 0.035
"""Distance of the front beyond the contact from which it counts as having slid past [m]."""
FORCE = 25.0
"""Change of the force on the base above which the object counts as jammed [N]."""
LONGEST = 20.0
"""Longest time of one push [s]."""

_FRESH = 0.03
"""Largest age of an observation that counts as present [s]."""


@final
@dataclass(frozen=True, kw_only=True)
class SteerPlan:
    """What is constant during a push."""

    pose: ApproachPose
    """Pose of the rolled trunk."""
    reach: float
    """Half of the object's width [m]."""
    rolls: bool
    """Whether the object rolls where the front faces; one that slides, or lies lower than the front's middle and is
    pressed on the ground, goes where the trunk goes."""


@final
@dataclass(frozen=True, kw_only=True)
class Steering:
    """Commanded motion of the base."""

    base: np.ndarray
    """Position of the base, shape (3,) [m]."""
    velocity: np.ndarray
    """Its velocity, shape (3,) [m/s]."""
    since: float
    """Time at which the push began [s]."""
    time: float
    """Time of this position [s]."""
    force: np.ndarray
    """Force on the base when the push began, shape (3,) [N]."""


def steer(state: Steering, time: float, seen: np.ndarray, goal: np.ndarray, plan: SteerPlan) -> Steering:
    """Motion one step later, for an object observed at ``seen`` that shall come to ``goal``, shapes (3,) [m]."""
    pose, is_free = plan.pose, not _gap(state, seen, plan) < CONTACT_GAP
    left = float(np.dot(goal - seen, pose.way))
    aside = float(np.dot(goal - seen, pose.right))
    heading = np.clip(aside / max(abs(left), plan.reach), -TURN, TURN)
    round_it = (plan.reach + pose.trunk.curve) * heading if plan.rolls else 0.0
    across = float(np.dot(seen - pose.front_of(state.base), pose.right)) - round_it
    along = SPEED if is_free else float(np.clip(GAIN * left, SLOWEST, SPEED))
    carry = 0.0 if is_free else along * heading
    gain = ASIDE_GAIN if plan.rolls or is_free else RECENTER
    sideways = float(np.clip(gain * across + carry, -ASIDE, ASIDE))
    wanted = along * pose.way + sideways * pose.right
    step = time - state.time
    velocity = state.velocity + min(1.0, AGILITY * step) * (wanted - state.velocity)
    return replace(state, base=state.base + step * velocity, velocity=velocity, time=time)


def is_over(state: Steering, observation: Observation, goal: np.ndarray, plan: SteerPlan) -> bool:
    """Whether the object is at the goal, shape (3,) [m], or jammed, or slid past, or the push takes too long.

    Only a present observation shows whether the trunk slid past the object.
    """
    camera, seen = observation.camera, seen_position(observation)
    is_there = float(np.dot(goal - seen, plan.pose.way)) <= NEAR
    is_fresh = camera is None or camera.time >= observation.time - _FRESH
    is_past = is_fresh and _gap(state, seen, plan) < -PASSED
    is_jammed = float(np.linalg.norm(observation.base_force - state.force)) > FORCE
    return is_there or is_past or is_jammed or state.time - state.since > LONGEST


def command_of(state: Steering, pose: ApproachPose) -> Command:
    """Command of a motion that is steered."""
    T_world_base = np.eye(4)
    T_world_base[:3, :3], T_world_base[:3, 3] = pose.rotation, state.base
    return Command(T_world_base=T_world_base, cable_tension=pose.tension)


def _gap(state: Steering, seen: np.ndarray, plan: SteerPlan) -> float:
    """Distance between the rolled trunk's front and the object along the way [m]."""
    return float(np.dot(seen - plan.pose.front_of(state.base), plan.pose.way)) - plan.reach
