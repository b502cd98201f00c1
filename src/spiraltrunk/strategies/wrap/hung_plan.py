"""Moves of a vertical wrap, planned from the object's announced position, size and mass, the design and its model.

Lengths are over the trunk's own where their unit is [-].
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from spiraltrunk.control.messages import Observation, Target
from spiraltrunk.control.strategy import Milestone
from spiraltrunk.design.trunk import TrunkDesign, ventral_cables
from spiraltrunk.strategies.moves import Move, MoveSequence, advance, base_position, edit_moves, insert_next
from spiraltrunk.strategies.sensing import base_directions, find_ventral, ventral_pull
from spiraltrunk.strategies.timing import ACCELERATION, still_time, stretch, travel_time
from spiraltrunk.strategies.wrap.hung_model import Wrap, predict_wrap, unrolled_center, wrap_tension

# All of these are ours, tuned in simulated trials.
BASE_BEND = 0.80
"""Bend of joint 1 under the load, over the joint limit [-]; it sets the tension."""
CONTACT = 0.30
"""Largest height of the object above the hanging tip [-]."""
HOOK = 0.85
"""The same over the length of the part that will be wrapped [-]: thin objects are touched near the tip."""
CLEARANCE = 0.08
"""Gap to the object before the trunk comes to touch it [-]: the object hangs up to 30 mm off its announced place."""
WITHDRAWAL = 0.16
"""Distance by which the open trunk leaves the object [-]."""
PRESS = 0.04
"""Travel of the trunk beyond the nominal contact [-]: a hanging object yields, and no gap is left."""
SINK = 0.01
"""Depth of the base below where the wrap bears the object, until it is tight [-]: strings keep the object level."""
HEFT = 0.20
"""Rise of each of the two tests of the load [-]."""
BACK_OFF = 0.15
"""Retreat of the base while the trunk opens [-]: a trunk that straightens pushes ahead, after 0.09 so far that
cylinders rock between the rims of their place for a second."""
DRAG = 0.04
"""Distance by which the opening trunk drags an object that does not roll [-]: it is set down short by as much."""
LIGHT = 0.5
"""Mass up to which a wrap is carried at the full acceleration [kg]: what is twice as heavy takes twice the time. At the
full one 1.2 kg bob by 20 mm on the trunk after the carry, and no hold counts."""
PRESS_SPEED = 0.15
"""Greatest speed at which the trunk comes to touch the object [m/s]: a faster one knocks the object off and follows."""
CURL_TIME = 2.3
"""Duration of the curl [s]: fast pulls shake the object."""
SETTLE_TIME = 0.3
"""Time after the curl until the wrap is tight [s]: the tension's last change goes through the trunk."""
HEFT_TIME = 0.9
"""Duration of a test of the load [s]: it rises in 0.7 s, and load and lever are smoothed over 0.2 s."""
LET_GO_TIME = 1.8
"""Time in which the trunk opens before another attempt [s]."""
STEADY_TIME = 1.6
"""Time for which the trunk leans on a released object [s]: friction on the trunk damps its swing."""
OVERSHOOT = 0.3
"""Depth below the expected touch-down to which the base is lowered in search of the table [-]."""
NEAR = 0.045
"""Height above the expected touch-down from which the object is lowered slowly, over the length and the square of
`stretch` [-]. From 0.08 its low end still had 19 to 97 mm to the table in simulated trials, of 40 mm planned. A long
trunk is thick where it lies under the object, and meets the table sooner: with a radius of 55 mm six of 60 passed a
torque limit of the arm without the square, and none with it, both without moving along what touched with one end."""
NEAR_TILTED = 2.0
"""Addition for an object that is held beside its middle, over that lever [-]: its low end touches early. At 1.25
and 1.5 some met the table while the arm still slowed down, and its torques passed their limit (simulated trials)."""
TOUCH_SPEED = 0.029
"""Speed at which an object is set down [m/s]: a shut trunk is stiff, and passes the impact on to the arm, whose last
joints bear 12 N m. From 0.035 on, some meet that limit, and long trunks before (`touch_speed`)."""
FALL = 1.5
"""Duration of the lowering times that speed over its way [-]: a minimum-jerk path that begins at a speed keeps it over
two fifths of its time at 1.5."""
EASE = 0.5
"""Tension kept at touch-down, over the tension that carried the object [-]."""
EASE_RISE = 0.12
"""Rise of the base meanwhile, over the length and the cube of `stretch` [-]: a long, thick trunk takes the object along
and drops it as it opens. With a radius of 55 mm, of which the cube makes half of this rise, 57 of 60 simulated trials
succeeded with half of it and 53 with all of it, both without moving along what touched with one end."""
EASE_TIME = 0.4
"""Duration of the easing [s]."""
OPEN_TIME = 3.0
"""Duration of the opening [s]: opened faster, the trunk flings a cylinder against the rim of its place, and its joints
do not open from the base on."""
LEAVE_SPEED = 0.6
"""Greatest speed at which the open trunk leaves [m/s]."""
LEAVE_ACCELERATION = 2.4
"""The same of its acceleration [m/s^2]."""
REST_TIME = 1.0
"""Time at the end in which the object comes to rest [s]: cylinders rock between the rims of their place. Of four that
still rocked after 0.6 s three lie still, after 1.3 s all; the grasp takes 20 s."""

_PHASES = {
    "reach": ("approach", "turn", "descend", "near", "touch"),
    "prehension": ("curl", "settle", "heft", "tighten", "try"),
    "transport": ("level", "steady", "lift", "carry", "hold"),
    "release": ("bring", "lower", "uncurl", "open", "draw off", "leave", "rest"),
}
_PHASE = {action: phase for phase, actions in _PHASES.items() for action in actions}

_MILESTONES = {
    "touch": Milestone.TOUCHED,
    "lift": Milestone.LIFTED,
    "carry": Milestone.CARRIED,
    "hold": Milestone.HELD,
    "lower": Milestone.SET_DOWN,
    **dict.fromkeys(_PHASES["release"][2:], Milestone.RELEASED),
}


def plan_wrap(observation: Observation) -> tuple[Move, ...]:
    """Moves of the whole task."""
    ventral = find_ventral(observation.task.design)
    tension, wrap = plan_grip(observation)
    return _moves(observation, tension * ventral, wrap)


def plan_grip(observation: Observation) -> tuple[float, Wrap]:
    """Tension of each ventral cable that holds the announced object [N], and the trunk wrapped round it."""
    design, target = observation.task.design, observation.task.target
    tension = wrap_tension(design, target.width, target.mass, BASE_BEND * design.joint_limit)
    return tension, predict_wrap(design, target.width, target.mass, tension)


def wrap_move(
    action: str, duration: float, position: np.ndarray, tension: np.ndarray, rotation: np.ndarray | None = None
) -> Move:
    """A move of a hung or a standing wrap, which its action assigns to a phase and a milestone."""
    return Move(
        phase=_PHASE[action], action=action, milestone=_MILESTONES.get(action), duration=duration, position=position,
        tension=tension, rotation=rotation,
    )  # fmt: skip


def _moves(observation: Observation, pull: np.ndarray, wrap: Wrap) -> tuple[Move, ...]:
    design, target, goal = observation.task.design, observation.task.target, observation.task.goal
    down, ahead = base_directions(observation)
    length, slack, center = design.length, 0.0 * pull, wrap.center
    contact = min(CONTACT * length, HOOK * float(design.section_length[wrap.first :].sum()))
    from_object = _base_beside(design, target, contact, down, ahead)
    beside = target.position + from_object
    touching = beside + PRESS * length * ahead
    wrapped = target.position - center[0] * down - center[1] * ahead + SINK * length * down
    hefted = wrapped - HEFT * length * down
    lifted = hefted - goal.lift * down
    over = lifted + goal.aside
    placing = goal.place - center[0] * down - (center[1] + DRAG * length) * ahead
    near, low = placing - NEAR * stretch(design) ** 2 * length * down, placing + OVERSHOOT * length * down
    clear = placing - BACK_OFF * length * ahead
    opened = clear + np.dot(goal.place + from_object - clear, down) * down
    away, here = opened - WITHDRAWAL * length * ahead, observation.T_world_base[:3, 3]
    aside = beside - CLEARANCE * length * ahead
    acceleration = ACCELERATION * min(1.0, LIGHT / target.mass) ** 2
    return (
        wrap_move("approach", still_time(design, aside - here), aside, slack),
        wrap_move("touch", travel_time(touching - aside, speed=PRESS_SPEED), touching, slack),
        wrap_move("curl", CURL_TIME, wrapped, pull),
        wrap_move("settle", SETTLE_TIME, wrapped, pull),
        wrap_move("heft", HEFT_TIME, hefted, pull),
        wrap_move("lift", travel_time(lifted - hefted, acceleration=acceleration), lifted, pull),
        wrap_move("carry", travel_time(over - lifted, acceleration=acceleration), over, pull),
        wrap_move("hold", goal.hold, over, pull),
        wrap_move("bring", travel_time(near - over, acceleration=acceleration), near, pull),
        wrap_move("lower", lowering_time(design, near, low), low, pull),
        wrap_move("leave", travel_time(away - clear, speed=LEAVE_SPEED, acceleration=LEAVE_ACCELERATION), away, slack),
        wrap_move("rest", REST_TIME, away, slack),
    )


def wrap_again(sequence: MoveSequence, shift: np.ndarray, back: np.ndarray) -> MoveSequence:
    """The sequence with the object put back onto its strings, let go and wrapped once more, displaced by ``shift``.

    The place where the object is set down is kept. While the trunk opens, the base retreats by ``back``; both of shape
    (3,) [m].
    """
    last = {move.action: i for i, move in enumerate(sequence.moves)}
    beside, curl, settle, heft = (sequence.moves[last[action]] for action in ("touch", "curl", "settle", "heft"))
    now = sequence.move
    risen = now.position - heft.position if now.action == "rise on" else 0.0 * shift
    lower = replace(settle, action="put back", duration=travel_time(now.position - settle.position))
    aside = beside.position + shift + back
    opened = replace(
        settle, action="let go", duration=LET_GO_TIME, tension=0.0 * settle.tension, position=settle.position + back
    )
    steady = replace(beside, action="steady", duration=STEADY_TIME)
    away = replace(opened, action="draw back", duration=travel_time(aside - opened.position), position=aside)

    def displace(move: Move) -> Move:
        return replace(move, position=move.position + shift - risen) if move.phase == "transport" else move

    again = (
        replace(move, phase="prehension", position=move.position + shift)
        for move in (beside, steady, curl, settle, heft)
    )
    first = max(last["heft"], sequence.index) + 1
    kept = replace(sequence, moves=(*sequence.moves[: sequence.index + 1], *sequence.moves[first:]))
    is_lifted = now.action in ("heft", "rise on")
    return insert_next(
        edit_moves(kept, sequence.index + 1, displace), (*((lower,) if is_lifted else ()), opened, away, *again)
    )


def touch_speed(design: TrunkDesign) -> float:
    """Speed at which an object is set down [m/s]: lower for long trunks.

    They are heavier, stiffer when shut, and reach further from the arm's last joints. With the square of the length
    joint 6 met its limit in 4 of 30 trials with a radius of 55 mm, with the fourth power in none of the four.
    """
    return TOUCH_SPEED / stretch(design) ** 4


def lowering_time(design: TrunkDesign, above: np.ndarray, low: np.ndarray) -> float:
    """Duration of the lowering at `touch_speed` between two positions of the base, each (3,) [m] [s]."""
    return FALL * float(np.linalg.norm(low - above)) / touch_speed(design)


def bring_higher(design: TrunkDesign, sequence: MoveSequence, rise: float) -> MoveSequence:
    """The sequence with the slow lowering from higher by ``rise`` [m]."""
    up = np.array([0.0, 0.0, rise])
    longer = lowering_time(design, up, 0.0 * up)

    def change(move: Move) -> Move:
        if move.action == "bring":
            return replace(move, position=move.position + up)
        return replace(move, duration=move.duration + longer) if move.action == "lower" else move

    return edit_moves(sequence, sequence.index + 1, change)


def sag_correction(observation: Observation) -> np.ndarray:
    """Displacement of the base that corrects for joints opened further than planned by the load, shape (3,) [m]."""
    design, width = observation.task.design, observation.task.target.width
    down, ahead = base_directions(observation)
    wrap = plan_grip(observation)[1]
    planned = unrolled_center(design, width, float(wrap.pull[ventral_cables(design)].mean()))
    lower, further = unrolled_center(design, width, ventral_pull(observation)) - planned
    return np.asarray(-lower * down - further * ahead)


def ease_and_open(sequence: MoveSequence, observation: Observation) -> MoveSequence:
    """Slacken and rise at touch-down, then open there and back off.

    An unloaded, tight trunk climbs up the object to the housing. A trunk that is drawn up while its tip is still curled
    drags the object along. The rise of a long trunk takes longer by the fourth power of its length: it is heavier, and
    its inertia acts further from the arm's last joints.
    """
    design, down = observation.task.design, base_directions(observation)[0]
    length, longer = design.length, stretch(design)
    position = base_position(sequence, observation.time) + -EASE_RISE / longer**3 * length * down
    eased = EASE * sequence.move.tension
    ease = replace(
        sequence.move, action="ease", milestone=Milestone.RELEASED, duration=longer**4 * EASE_TIME, position=position,
        tension=eased,
    )  # fmt: skip
    back = BACK_OFF * length * observation.T_world_base[:3, 1]
    uncurl = replace(ease, action="uncurl", duration=longer * OPEN_TIME, position=position + back, tension=0.0 * eased)
    return advance(insert_next(sequence, (ease, uncurl)), observation.time)


def _base_beside(
    design: TrunkDesign, target: Target, contact: float, down: np.ndarray, ahead: np.ndarray
) -> np.ndarray:
    """From the object to the base of a hanging trunk that touches it ``contact`` above its tip, shape (3,) [m]."""
    along = design.length - contact
    radius = np.interp(along, np.cumsum(design.section_length) - design.section_length / 2, design.section_radius)
    return -along * down - (target.width / 2 + radius) * ahead
