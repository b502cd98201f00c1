"""Where the trunk's tip gripper goes and how it turns: geometry shared by the strategies that grip with the fingers.

The trunk hangs straight, so that its end is where the arm puts it, to a fraction of a millimetre; heights and openings
follow from the gripper's fingers and the object's announced size.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import final

import numpy as np
from scipy.spatial.transform import Rotation

from spiraltrunk.control.messages import Goal, Observation, Target
from spiraltrunk.design.gripper import GripperDesign
from spiraltrunk.design.rules import GRAVITY
from spiraltrunk.errors import ModelError
from spiraltrunk.strategies.fingertip.finger_model import closing_tension, opening_tension
from spiraltrunk.strategies.options import check_choices


@final
@dataclass(frozen=True, kw_only=True)
class TipOptions:
    """What the strategies choose; lengths are parts of a finger's own unless said otherwise."""

    clearance: float = 0.05
    """Gap between the trunk's end and the object [-]."""
    ground_gap: float = 0.02
    """Gap between straight fingers and the ground [-]: what is thin lies near their ends, and creeps off them."""
    reach: float = 0.75
    """How deep below the trunk's end the object's middle comes to lie, at least [-]."""
    room: float = 0.08
    """Gap between open fingertips and a centred object as wide as may be: what a look is wrong by [-]."""
    size_error: float = 0.10
    """Part by which the object may be larger than announced [-]."""
    hover: float = 2.0
    """Height above the grip from which the robot looks and weighs [-]."""
    safety: float = 3.0
    """Friction that may be counted on, over what the grip makes do with [-]."""
    press_least: float = 0.5
    """Least force of a fingertip, over its largest [-]."""
    slip: float = 0.15
    """Sinking of the held object, as seen, that counts as slipping [-]."""
    tighten: float = 1.3
    """Factor on the fingers' tension where the object slips [-]."""
    risen: float = 0.5
    """Part of the lift, or of the object's weight, from which it counts as held [-]."""
    touch: float = 0.25
    """Relief that tells that the ground is met [N]: beyond what smoothing leaves of the arm's noise."""
    firmer: float = 1.6
    """Factor on the fingers' tension with each try after the first [-]: smooth cones slip out of the first grip."""
    retries: int = 1
    """How often to try again [-]."""

    def __post_init__(self) -> None:
        check_choices(self, positive=("reach", "hover", "safety", "tighten", "risen", "firmer"))


def gripper_of(observation: Observation) -> GripperDesign:
    """The trunk's gripper.

    Raises:
        ModelError: where it has none.
    """
    gripper = observation.task.design.gripper
    if gripper is None:
        raise ModelError("this trunk has no gripper; allowed: a design with [gripper]")
    return gripper


def ground_height(target: Target, goal: Goal) -> float:
    """Height of what the object rests on [m]; where that is not told, half its width below it."""
    return float(target.position[2]) - target.width / 2 if goal.ground is None else goal.ground


def object_height(target: Target, goal: Goal) -> float:
    """How high the object stands above what it rests on [m]."""
    return 2 * (float(target.position[2]) - ground_height(target, goal))


def tip_height(gripper: GripperDesign, target: Target, goal: Goal, options: TipOptions) -> float:
    """Height of the trunk's end while it grips [m].

    As low as the straight fingers clear the ground, the end clears the object, and the open fingers find room round it,
    but the object's middle at least ``reach`` of their length below the end.

    Raises:
        ModelError: where the fingers open too little for the object.
    """
    if target.width > gripper.grasp_width:
        raise ModelError(_TOO_WIDE.format(1e3 * target.width, 1e3 * gripper.grasp_width))
    height, gap = object_height(target, goal), options.clearance * gripper.finger_length
    low = max((1 + options.ground_gap) * gripper.finger_length, (1 + options.size_error) * height + gap)
    low = max(low, height / 2 + options.reach * gripper.finger_length)
    for above in np.linspace(low, low + gripper.finger_length, _HEIGHTS):
        if _opening(gripper, target, height, float(above), options) is not None:
            return ground_height(target, goal) + float(above)
    raise ModelError(_TOO_WIDE.format(1e3 * target.width, 1e3 * gripper.grasp_width))


def opening(gripper: GripperDesign, target: Target, goal: Goal, options: TipOptions) -> float:
    """Gripper command that opens the fingers round the object, -1 to 0 [-]."""
    above = tip_height(gripper, target, goal, options) - ground_height(target, goal)
    tension = _opening(gripper, target, object_height(target, goal), above, options)
    return -(gripper.tension_max if tension is None else tension) / gripper.tension_max


def _opening(gripper: GripperDesign, target: Target, height: float, above: float, options: TipOptions) -> float | None:
    """Tension that opens the fingers round the object, the trunk's end ``above`` what it rests on [m]."""
    larger = 1 + options.size_error
    radius, room = larger * _reach_out(target), options.room * gripper.finger_length
    top = above - larger * height

    def outline(depth: np.ndarray, skin: np.ndarray) -> np.ndarray:
        if target.kind == "sphere":
            return np.sqrt(np.maximum((radius + room + skin) ** 2 - (depth - top - radius) ** 2, 0.0))
        below = np.clip((depth + skin - top) / (larger * height), 0.0, 1.0)
        share = below if target.kind == "cone" else below > 0
        return np.where(below > 0, share * radius + room + skin, 0.0)

    return opening_tension(gripper, outline)


def _reach_out(target: Target) -> float:
    """How far the object reaches from its middle, seen from above where it stands, else across its axis [m].

    A camera does not tell how a standing box is turned: its corners may be where the fingers are.
    """
    is_turned_anyhow = target.kind == "box" and abs(float(target.axis[2])) > 0.5
    return target.width / 2 * (math.sqrt(2.0) if is_turned_anyhow else 1.0)


_TOO_WIDE = "the fingers do not open round {:.0f} mm; allowed: up to {:.0f} mm, and low objects"

_HEIGHTS = 39
"""Heights tried: a millimetre apart for the paper's fingers."""


def closing(gripper: GripperDesign, target: Target, options: TipOptions) -> float:
    """Gripper command that holds the object by friction, and no harder than that takes, 0 to 1 [-].

    A finger that presses with N on a side that narrows upwards by an angle a lifts by N (mu cos a - sin a), with the
    friction mu that may be counted on over the safety; where that is nothing, it presses as hard as it can.
    """
    slope = math.atan2(target.width / 2, target.length) if target.kind == "cone" else 0.0
    lifting = target.friction / options.safety * math.cos(slope) - math.sin(slope)
    most, weight = closing_most(gripper), target.mass * GRAVITY
    needed = min(most, weight / (gripper.n_finger * lifting)) if lifting > 0 else most
    least = options.press_least * most
    return closing_tension(gripper, target.width / 2, max(needed, least)) / gripper.tension_max


def closing_most(gripper: GripperDesign) -> float:
    """Force of a straight finger's tip at the gripper's largest tension [N]."""
    return gripper.tension_max / closing_tension(gripper, gripper.mount_radius, 1.0)


def turned_across(start: np.ndarray, axis: np.ndarray, n_finger: int) -> np.ndarray:
    """Orientation of the base that sets one finger against the others across a horizontal axis, shape (3, 3) [-].

    One finger's direction stands square to the axis; of the 2 n equal ways it takes the one nearest to ``start``.
    An upright axis leaves everything as it is.
    """
    if math.hypot(axis[0], axis[1]) < 0.5:
        return start
    finger = math.atan2(start[1, 1], start[0, 1])
    across = math.atan2(axis[1], axis[0]) + math.pi / 2
    step = math.pi / n_finger if n_finger % 2 else math.pi / math.lcm(n_finger, 2)
    turn = (across - finger + step / 2) % step - step / 2
    return np.asarray(Rotation.from_rotvec([0.0, 0.0, turn]).as_matrix() @ start)
