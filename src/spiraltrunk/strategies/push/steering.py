"""Pushing an object along the ground to a place, steered by a camera's looks.

A single contact pushes unstably: whatever lies a little beside the fist's middle slides farther aside. So the fist
stays behind the object as seen from the place, moves towards the place no faster than the looks can follow, and slows
down as it gets there: a ball then stops with it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import final

import numpy as np

from spiraltrunk.control.messages import Command, Observation
from spiraltrunk.strategies.options import check_choices
from spiraltrunk.strategies.push.stance import Stance

_FRESH = 0.03
"""Age of a look that still is one of now [s]."""


@final
@dataclass(frozen=True, kw_only=True)
class SteerOptions:
    """How the fist is steered; the camera looks twice a second."""

    speed: float = 0.06
    """Greatest speed along the way [m/s]."""
    slowest: float = 0.012
    """Least speed along the way [m/s]."""
    gain: float = 1.0
    """Speed over the distance left [1/s]: half of that distance passes between two looks."""
    aside: float = 0.04
    """Greatest speed across the way [m/s]."""
    aside_gain: float = 1.5
    """Speed across the way over the distance from where the fist should be, free or behind what rolls [1/s]."""
    recenter: float = 0.2
    """The same behind what slides [1/s]: it sticks to the fist and is carried along."""
    turn: float = 0.5
    """Largest sideways part of the wanted way of the object [-]: the fist meets it no farther beside its middle."""
    agility: float = 6.0
    """Rate at which the speed follows what is wanted [1/s]."""
    near: float = 0.008
    """Distance left along the way that ends the push [m]."""
    passed: float = 0.035
    """How far the fist may be past where it should touch the object [m]: then it has slid past."""
    force: float = 25.0
    """Largest change of the force on the base [N]: more than that, and what is pushed is jammed."""
    longest: float = 20.0
    """Longest time of one push [s]."""

    def __post_init__(self) -> None:
        check_choices(self, positive=("speed", "slowest", "gain", "aside", "agility", "near", "force", "longest"))


@final
@dataclass(frozen=True, kw_only=True)
class Steering:
    """Where the fist's base is commanded to be, and how fast."""

    base: np.ndarray
    """Place of the base, shape (3,) [m]."""
    velocity: np.ndarray
    """Its velocity, shape (3,) [m/s]."""
    since: float
    """When the push began [s]."""
    time: float
    """Time of this place [s]."""
    force: np.ndarray
    """Force on the base when the push began, shape (3,) [N]."""


def steer(state: Steering, time: float, seen: np.ndarray, goal: np.ndarray, plan: SteerPlan) -> Steering:
    """The fist's base one step later, for an object ``seen`` that shall come to ``goal``, shapes (3,) [m]."""
    options, stance = plan.options, plan.stance
    left = float(np.dot(goal - seen, stance.way))
    aside = float(np.dot(goal - seen, stance.right))
    heading = np.clip(aside / max(abs(left), plan.reach), -options.turn, options.turn)
    round_it = (plan.reach + stance.fist.curve) * heading if plan.rolls else 0.0
    across = float(np.dot(seen - stance.front_of(state.base), stance.right)) - round_it
    ahead = np.clip(options.gain * left, options.slowest, options.speed) if _gap(state, seen, plan) < 0.02 else None
    along = options.speed if ahead is None else float(ahead)
    carry = 0.0 if ahead is None else along * heading
    sideways = float(
        np.clip(
            (options.aside_gain if plan.rolls or ahead is None else options.recenter) * across + carry,
            -options.aside,
            options.aside,
        )
    )
    wanted = along * stance.way + sideways * stance.right
    step = time - state.time
    velocity = state.velocity + min(1.0, options.agility * step) * (wanted - state.velocity)
    return replace(state, base=state.base + step * velocity, velocity=velocity, time=time)


def is_over(state: Steering, observation: Observation, goal: np.ndarray, plan: SteerPlan) -> bool:
    """Whether the object is there, or jammed, or the fist has slid past it, or it takes too long.

    Whether the fist is past the object, only a fresh look tells.
    """
    options, look, seen = plan.options, observation.look, seen_place(observation)
    is_there = float(np.dot(goal - seen, plan.stance.way)) <= options.near
    is_fresh = look is None or look.time >= observation.time - _FRESH
    is_past = is_fresh and _gap(state, seen, plan) < -options.passed
    is_jammed = float(np.linalg.norm(observation.base_force - state.force)) > options.force
    return is_there or is_past or is_jammed or state.time - state.since > options.longest


def command_of(state: Steering, stance: Stance) -> Command:
    """The command that holds the fist where it is steered to."""
    T_world_base = np.eye(4)
    T_world_base[:3, :3], T_world_base[:3, 3] = stance.rotation, state.base
    return Command(T_world_base=T_world_base, cable_tension=stance.tension)


@final
@dataclass(frozen=True, kw_only=True)
class SteerPlan:
    """What does not change during a push."""

    stance: Stance
    """How the fist stands."""
    reach: float
    """Half of the object's width [m]."""
    rolls: bool
    """Whether the object rolls: it goes where the fist's face points. What slides, or is lower than the fist's middle
    and thus pressed on the ground, goes where the fist goes."""
    options: SteerOptions
    """How it is steered."""


def _gap(state: Steering, seen: np.ndarray, plan: SteerPlan) -> float:
    """Distance between the fist's front and the object along the way [m]."""
    return float(np.dot(seen - plan.stance.front_of(state.base), plan.stance.way)) - plan.reach


def seen_place(observation: Observation) -> np.ndarray:
    """Where the object was seen last, or was announced to be where no camera looks, shape (3,) [m]."""
    return observation.task.target.position if observation.look is None else observation.look.position
