"""What kick and sweep share: where the rolled-up trunk must stand to meet an object, and the moves that bring it there.

The trunk is rolled up by its ventral cables alone, in the air, then tilted and laid before the ground, so that it meets
objects low: an object pushed above about three times its half-width may topple, and a ball pushed above its middle jams
between ground and trunk where friction is high.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from spiraltrunk.control.messages import Command, Observation, Target, Task
from spiraltrunk.design.trunk import ventral_cables
from spiraltrunk.errors import ModelError
from spiraltrunk.strategies.moves import Move, Progress, fraction
from spiraltrunk.strategies.push.rolled_model import Fist, fist_orientation, predict_fist
from spiraltrunk.strategies.sensing import in_step

TILT = math.radians(60.0)
"""Tilt of the trunk's base from hanging towards the push [rad] (ours): flat enough for a low front, and the housing
stays clear of the ground."""

TENSION = 0.9
"""Tension of the ventral cables over the largest one [-] (ours): the more, the stiffer the fist."""

CLEARANCE = 0.005
"""Gap between fist and ground [m] (ours)."""

ABOVE = 0.35
"""Height of the base while the tightly rolled trunk is tilted, over the trunk's length [-] (ours): the curl clears."""


LEAD = 0.02
"""How far one ventral cable may be pulled in beyond the other, over the stroke [-] (ours)."""


@final
@dataclass(frozen=True, kw_only=True)
class Stance:
    """How the fist stands to push an object along one way."""

    way: np.ndarray
    """Unit vector of the push, level, shape (3,) [-]."""
    rotation: np.ndarray
    """Orientation of the base, shape (3, 3) [-]."""
    tension: np.ndarray
    """Tensions that keep the trunk rolled up, shape (n_cable,) [N]."""
    fist: Fist
    """Where its front is."""
    height: float
    """Height of the base above which the front meets the object as wanted, in the world [m]."""

    @property
    def right(self) -> np.ndarray:
        """Unit vector to the right of the push, to which the fist lies beside its base, shape (3,) [-]."""
        return np.array([self.way[1], -self.way[0], 0.0])

    def base_behind(self, place: np.ndarray, gap: float) -> np.ndarray:
        """Where the base stands when the front is ``gap`` [m] behind a place, shape (3,) [m]."""
        beside = place - (self.fist.forward + gap) * self.way - self.fist.lateral * self.right
        return np.array([beside[0], beside[1], self.height])

    def front_of(self, base: np.ndarray) -> np.ndarray:
        """Foremost point of the fist for a place of its base, shape (3,) [m]."""
        ahead = base + self.fist.forward * self.way + self.fist.lateral * self.right
        return np.array([ahead[0], ahead[1], base[2] - self.fist.below])


def plan_stance(task: Task, contact: float) -> Stance:
    """A stance for the way from the object to its goal; ``contact`` is where to meet it, over its height [-].

    The fist meets no object lower than its own radius, and balls as low as it can.

    Raises:
        ModelError: where no cable pulls ventral, the task has no ground, or the object is at its goal already.
    """
    design, target, goal = task.design, task.target, task.goal
    ventral = ventral_cables(design)
    if not ventral.any():
        raise ModelError("no cable pulls ventral; allowed: a design with a cable more than 90 deg from dorsal")
    if goal.ground is None:
        raise ModelError("the object hangs; allowed: an object on the ground, which can be pushed")
    way = (goal.place - target.position) * [1.0, 1.0, 0.0]
    distance = float(np.linalg.norm(way))
    if distance < 1e-6:
        raise ModelError("the object is where it shall be pushed; allowed: a goal beside it")
    fist = predict_fist(design, TILT)
    lowest = goal.ground + fist.bottom + CLEARANCE
    middle = contact * 2 * (float(target.position[2]) - goal.ground)
    wanted = goal.ground + (0.0 if target.kind == "sphere" else middle) + fist.below
    return Stance(
        way=way / distance, rotation=fist_orientation(way / distance, TILT), fist=fist, height=max(lowest, wanted),
        tension=TENSION * design.cable.tension_max * ventral,
    )  # fmt: skip


def reach_of(target: Target) -> float:
    """Half of the object's largest extent seen from above [m]: a box may stand with an edge towards the fist."""
    across = target.width * (math.sqrt(2.0) if target.kind == "box" else 1.0)
    lying = abs(float(target.axis[2])) < 0.7 and target.kind != "sphere"
    return max(across, target.length if lying else 0.0) / 2


def roll_up(observation: Observation, stance: Stance, base: np.ndarray) -> tuple[Move, ...]:
    """Moves that roll the trunk up in the air above ``base`` and turn it into its stance."""
    ground = stance.height - stance.fist.bottom
    air = np.array([base[0], base[1], max(base[2], ground + (ABOVE + 1.0) * observation.task.design.length)])
    over = np.array([base[0], base[1], max(base[2], ground + ABOVE * observation.task.design.length)])
    curl = Move(phase="reach", action="roll up", duration=2.5, position=air, tension=stance.tension)
    turn = Move(
        phase="reach", action="turn", duration=2.0, position=over, tension=stance.tension, rotation=stance.rotation
    )
    return curl, turn


def go_down(stance: Stance, base: np.ndarray) -> tuple[Move, ...]:
    """Moves that bring the fist beside an object, then down."""
    over = base + np.array([0.0, 0.0, 0.10])
    beside = Move(
        phase="reach", action="come beside", duration=1.0, position=over, tension=stance.tension,
        rotation=stance.rotation,
    )  # fmt: skip
    down = Move(
        phase="reach", action="come down", duration=1.0, position=base, tension=stance.tension,
        rotation=stance.rotation,
    )  # fmt: skip
    return beside, down


def keep_level(command: Command, progress: Progress, observation: Observation) -> Command:
    """The command with the ventral cables kept in step from when the trunk is rolled up until it is unrolled.

    Held by tension alone, a fist gives way out of its plane: one cable takes in what the other pays out. While the
    trunk is turned into its stance, the one ahead is held until the other has caught up.
    """
    action = progress.move.action
    if action in ("roll up", "unroll", "look over"):
        return command
    ahead = 2.0 - fraction(progress, observation.time) if action == "turn" else 1.0
    return replace(command, cable_pull=in_step(observation, ahead * LEAD))
