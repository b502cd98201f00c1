"""Moves of a vertical wrap, planned from the object's announced place, size and mass with the design and its model."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import final

import numpy as np

from spiraltrunk.control.messages import Observation, Target
from spiraltrunk.control.strategy import Milestone
from spiraltrunk.design.trunk import TrunkDesign, ventral_cables
from spiraltrunk.errors import ModelError
from spiraltrunk.strategies.moves import Move, Progress
from spiraltrunk.strategies.options import check_choices
from spiraltrunk.strategies.wrap.hung_model import Wrap, predict_wrap, wrap_tension

OVERSHOOT = 0.3
"""How far beyond the expected touch the arm goes down to find the table, over the trunk's length [-]."""

LOWERING_SPEED = 0.05
"""Speed at which an object is set down [m/s]."""

_MILESTONES = {
    "touch": Milestone.TOUCHED,
    "lift": Milestone.LIFTED,
    "carry": Milestone.CARRIED,
    "hold": Milestone.HELD,
    "lower": Milestone.SET_DOWN,
    **dict.fromkeys(("draw up", "leave", "rest"), Milestone.RELEASED),
}
"""What the actions work towards."""

RISING_SPEED = 0.1
"""Mean speed at which what was hefted is put back onto its strings [m/s]."""


@final
@dataclass(frozen=True, kw_only=True)
class WrapOptions:
    """What the strategy chooses; lengths are parts of the trunk's own."""

    contact: float = 0.30
    """Largest height of the object above the hanging tip, over the trunk's length [-]."""
    hook: float = 0.85
    """The same over the length of the part that will be wrapped [-]: thin objects take the tip alone."""
    clearance: float = 0.16
    """Gap to the object before the approach, over the trunk's length [-]."""
    press: float = 0.04
    """How far beyond the nominal contact the trunk goes, over its length [-]: what hangs gives way, a gap does not."""
    sink: float = 0.01
    """How far below the place where the wrapped trunk would bear the object the arm waits until the wrap is tight, over
    the trunk's length [-]: as long as strings bear it, the object stays level."""
    base_bend: float = 0.80
    """Bend that joint 1 keeps under the load, over its limit [-]; it sets the tension."""
    heft: float = 0.20
    """How far the arm rises to feel what it holds, and once more where that may not do, over the trunk's length [-]."""
    back_off: float = 0.09
    """How far the arm backs off while the trunk opens, over the trunk's length [-]: straightening, it pushes ahead."""
    drag: float = 0.04
    """How far the opening trunk drags what does not roll along, over its length [-]: it is set down that much short."""
    ease: float = 0.5
    """Tension kept when the object touches down, over the tension that carried it [-]."""
    ease_rise: float = 0.12
    """How far the arm rises meanwhile, over the trunk's length [-]."""
    open_time: float = 3.0
    """Time to open [s]."""
    steady_time: float = 2.5
    """Time to lean on what was let go [s]: it swings on its strings, and rubbing on the trunk stops it."""
    curl_time: float = 4.0
    """Time to curl [s]: fast pulls shake the object."""
    lead: float = 0.03
    """How far one ventral cable may be pulled in beyond the other, over the stroke [-]: keeps the wrap in its plane. A
    winder gives way by its pull over its stiffness (3 mm at 60 N and 20 N/mm): with less, none would pull in full."""
    slip: float = 0.04
    """Cable that pays out while carrying, over the stroke, that counts as unrolling [-]."""
    felt: float = 0.15
    """Cable that stays out, over what an empty trunk would take in at that tension, that tells a contact [-]."""
    reach_on: float = 0.08
    """How far further ahead to try where nothing was felt, over the trunk's length [-]."""
    off_center: float = 0.018
    """Lever of the load along its own axis at which the grasp is tried once more, over the trunk's length [-]."""
    off_center_thin: float = 0.25
    """The same over the object's width, whichever is less: friction has no longer a lever against the tilting [-]."""
    off_center_heavy: float = 0.012
    """The same over the width and the tension in the object's weight: what presses friction is the tension [-]."""
    worse: float = 2.5
    """How many times that lever is too much after a second wrap, which a swinging object may have met worse [-]."""
    recenter: float = 0.65
    """Part of that lever to move by [-]: in a single loop, an object held beside its centre slides on as it tilts."""
    retries: int = 2
    """How often to try again [-]."""
    touch: float = 0.5
    """Part of the object's weight that tells, in the arm's torques, whether it is carried or set down [-]."""
    turn: float = 0.5
    """Part of the way from an object's low end staying put, while it turns flat, to its centre staying put [-]."""
    turn_least: float = 0.02
    """Way over the trunk's length from which it is worth while to move along before setting down [-]."""
    turn_rise: float = 0.08
    """How far the arm rises to move along, over the trunk's length [-]."""

    def __post_init__(self) -> None:
        check_choices(self, positive=("open_time", "steady_time", "curl_time"))


def plan_wrap(observation: Observation, options: WrapOptions) -> tuple[Move, ...]:
    """Places of the base and tensions for the whole task.

    Raises:
        ModelError: where no cable pulls ventral.
    """
    ventral = ventral_cables(observation.task.design)
    if not ventral.any():
        raise ModelError("no cable pulls ventral; allowed: a design with a cable more than 90 deg from dorsal")
    tension, wrap = plan_grip(observation, options)
    return _moves(observation, options, tension * ventral, wrap)


def plan_grip(observation: Observation, options: WrapOptions) -> tuple[float, Wrap]:
    """Tension of each ventral cable that holds the object as announced [N], and the trunk wrapped round it."""
    design, target = observation.task.design, observation.task.target
    tension = wrap_tension(design, target.width, target.mass, options.base_bend * design.joint_limit)
    return tension, predict_wrap(design, target.width, target.mass, tension)


def _moves(observation: Observation, options: WrapOptions, pull: np.ndarray, wrap: Wrap) -> tuple[Move, ...]:
    design, target, goal = observation.task.design, observation.task.target, observation.task.goal
    down, ahead = observation.T_world_base[:3, 0], -observation.T_world_base[:3, 1]
    length, slack, center = design.length, 0.0 * pull, wrap.center
    contact = min(options.contact * length, options.hook * float(design.section_length[wrap.first :].sum()))
    from_object = _beside(design, target, contact, down, ahead)
    beside = target.position + from_object
    touching = beside + options.press * length * ahead
    wrapped = target.position - center[0] * down - center[1] * ahead + options.sink * length * down
    hefted = wrapped - options.heft * length * down
    lifted = hefted - goal.lift * down
    over = lifted + goal.aside
    placing = goal.place - center[0] * down - (center[1] + options.drag * length) * ahead
    above = placing + np.array([0.0, 0.0, (over - placing)[2]])
    low = placing + OVERSHOOT * length * down
    clear = placing - options.back_off * length * ahead
    opened = clear + np.dot(goal.place + from_object - clear, down) * down

    def move(phase: str, action: str, duration: float, position: np.ndarray, tension: np.ndarray) -> Move:
        return Move(
            phase=phase, action=action, milestone=_MILESTONES.get(action), duration=duration, position=position,
            tension=tension,
        )  # fmt: skip

    return (
        move("reach", "approach", 2.0, beside - options.clearance * length * ahead, slack),
        move("reach", "touch", 1.5, touching, slack),
        move("prehension", "curl", options.curl_time, wrapped, pull),
        move("prehension", "settle", 1.0, wrapped, pull),
        move("prehension", "heft", 1.5, hefted, pull),
        move("transport", "lift", 2.0, lifted, pull),
        move("transport", "carry", 2.0, over, pull),
        move("transport", "hold", goal.hold, over, pull),
        move("release", "bring", 1.5, above, pull),
        move("release", "lower", lowering_time(above, low), low, pull),
        move("release", "draw up", 2.0, opened, slack),
        move("release", "leave", 2.0, opened - options.clearance * length * ahead, slack),
        move("release", "rest", 2.5, opened - options.clearance * length * ahead, slack),
    )


def wrap_again(progress: Progress, shift: np.ndarray, back: np.ndarray, options: WrapOptions) -> Progress:
    """The same sequence with the object put back onto its strings, let go and wrapped once more, all ``shift`` on.

    Where it shall be set down stays as it was.

    Args:
        progress: in prehension.
        shift: from the last wrap to the next, shape (3,) [m].
        back: how far the arm backs off while the trunk opens, shape (3,) [m].
        options: what the strategy chose.
    """
    last = {move.action: i for i, move in enumerate(progress.moves)}
    beside, curl, settle, heft = (progress.moves[last[action]] for action in ("touch", "curl", "settle", "heft"))
    risen = progress.move.position - heft.position if progress.move.action == "rise on" else 0.0 * shift
    lower = replace(settle, action="put back", duration=1.0 + float(np.linalg.norm(risen)) / RISING_SPEED)
    opened = replace(
        settle, action="let go", duration=3.0, tension=0.0 * settle.tension, position=settle.position + back
    )
    steady = replace(beside, action="steady", duration=options.steady_time)
    away = replace(opened, action="draw back", duration=2.0, position=beside.position + shift + back)
    again = (
        *((lower,) if progress.move.action in ("heft", "rise on") else ()), opened, away,
        *(
            replace(move, phase="prehension", position=move.position + shift)
            for move in (beside, steady, curl, settle, heft)
        ),
    )  # fmt: skip
    later = (
        replace(move, position=move.position + shift - risen) if move.phase == "transport" else move
        for move in progress.moves[max(last["heft"], progress.index) + 1 :]
    )
    return replace(progress, moves=(*progress.moves[: progress.index + 1], *again, *later))


def lowering_time(above: np.ndarray, low: np.ndarray) -> float:
    """Time to lower by that way [s]."""
    return float(np.linalg.norm(low - above)) / LOWERING_SPEED


def _beside(design: TrunkDesign, target: Target, contact: float, down: np.ndarray, ahead: np.ndarray) -> np.ndarray:
    """From the object to the base of a hanging trunk that touches it ``contact`` above its tip, shape (3,) [m]."""
    along = design.length - contact
    radius = np.interp(along, np.cumsum(design.section_length) - design.section_length / 2, design.section_radius)
    return -along * down - (target.width / 2 + radius) * ahead
