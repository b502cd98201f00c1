"""Opening round a standing object: in small steps of the ventral pull, the base following what still holds the object.

The trunk opens from the base, and its tip last. If tension is let go at once, the base swings the tip, still closed,
with the object in it: in simulated trials by 40 mm in 0.3 s, with some 4 N, so that light and slender objects toppled.
Here the pull falls step by step, and the base goes where the model has the hook round the object
(`hook_model`). The arm presses the object on the ground with `PRESS` meanwhile, as the arm's torques tell: a
hook whose base rises a little would lift it, and what is pressed on the ground neither slides nor leans easily. As far
as the housing clears the ground, the base turns with the sagging hook, so that the object stays upright. An object that
leans as it touches down is set upright by the time at which only the hook holds it, and what still leans then is
righted by what the camera sees. When the pull has fallen to `LAST`, the hook holds by little. Once the object stands
upright, it springs open. Beside an object wider than `WIDE` the tail curls up without closing round it, and the tail's
back would drag the object as the base follows. Once such an object stands, the trunk springs open at `LAST_WIDE` of
the loose pull.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from spiraltrunk.control.messages import CameraObservation, Observation
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.strategies.moves import Move, MoveSequence, command_at, edit_moves, insert_next, shift_later
from spiraltrunk.strategies.wrap.distal_plan import CLOSE
from spiraltrunk.strategies.wrap.hook_model import Hook, find_first, find_hook
from spiraltrunk.strategies.wrap.hung_plan import wrap_move
from spiraltrunk.strategies.wrap.set_down import find_ground, is_on_ground, righting
from spiraltrunk.strategies.wrap.standing_model import cable_pulls, girth_width, shut_pull
from spiraltrunk.strategies.wrap.standing_plan import clear_height

# All of these are ours, tuned in simulated trials.
EASE = 0.25
"""Largest step of the pull down to it, over the pull that shuts joint 1 [-]."""
STEP = 0.87
"""Ratio of the pulls of two steps below it [-]."""
LAST = 0.32
"""Pull from which the hook springs open, over the one that shuts joint 1 [-]. Followed further, its tip drags the
object: the model does not know where a tip lies that slides."""
WIDE = 0.13
"""Width from which the tail does not close round an object, over the trunk's length [-]: 65 mm for the paper's. The
width is that of the cylinder of the same girth."""
LAST_WIDE = 0.6
"""Pull from which the trunk springs open round such an object, over the one at which only the hook holds it [-]."""
LEAN_MOST = math.radians(4.0)
"""Largest lean at which an object that was set down counts as standing [rad]."""
STEP_TIME = 0.2
"""Duration of a step [s]."""
RUBBING_STEP_TIME = 0.4
"""The same where cables rub [s]: in half of it the tip gives way late, and drags a cylinder until it rocks."""
TURN = 0.12
"""Largest turn of the base in a step [rad]."""
CLEAR = 0.015
"""Gap between housing and ground [m]."""
SAG = 0.010
"""Depth below the ground to which the model's free trunk may sag [m]: it lies on the ground with a part of its weight,
while a base that gave way upwards would lift the object."""
PRESS = 0.8
"""Force by which the object is pressed on the ground [N]."""
PRESS_STEP = 0.0002
"""Sinking of the base at each reading for the whole of that force [m]: 10 mm/s."""
LEAST_WITHDRAWAL = 0.3
"""Least part of the planned withdrawal that is left to the base once the trunk is open [-]."""
RIGHT = 0.75
"""Part of a lean that is righted at each step [-]."""
UPRIGHT = math.radians(2.5)
"""Lean with which the trunk springs open [rad]: one that leans more is righted once more, as often as RIGHTINGS. For a
wide object it is LEAN_MOST."""
RIGHTINGS = 6
"""Largest number of further steps in which an object is righted [-]."""
RIGHTING_TIME = 0.5
"""Duration of such a step [s]: the camera looks again meanwhile."""
BAND = (0.2, 0.9)
"""Least and largest height of the hook over the object's length [-]."""

_UP = np.array([0.0, 0.0, 1.0])


def plan_opening(sequence: MoveSequence, observation: Observation, height: float) -> MoveSequence:
    """The sequence with the opening planned from where the object has touched down; unchanged without a camera.

    Args:
        sequence: moves, the present one lowering the object.
        observation: what is seen.
        height: at which the object is wrapped, from its foot [m].
    """
    camera = observation.camera
    if camera is None:
        return sequence
    eased = _plan_steps(sequence, observation, camera, girth_width(observation.task.target, height))
    last = eased[-1]
    opened, drawn = (next(m.position for m in sequence.moves if m.action == name) for name in ("open", "draw off"))
    aside = (last.position - opened) * [1.0, 1.0, 0.0]
    aside = aside - find_withdrawn(camera.position - observation.task.goal.place, aside, drawn - opened)

    return _leave_from(sequence, last, aside, eased)


def find_withdrawn(misplaced: np.ndarray, aside: np.ndarray, way: np.ndarray) -> np.ndarray:
    """Part of the planned withdrawal that the base has covered when the trunk is open, shape (3,) [m].

    The base follows the hook and goes back as the trunk straightens. The whole withdrawal from there would bring the
    arm's last link to its pedestal.

    Args:
        misplaced: from where the object was to stand to where its centre is, shape (3,) [m].
        aside: from where the base was to be once the trunk is open to where it is, shape (3,) [m].
        way: planned withdrawal of the base, shape (3,) [m].
    """
    level = np.array([way[0], way[1], 0.0])
    whole = float(np.linalg.norm(level))
    if whole < 1e-9:
        return 0.0 * level
    behind = float((aside - misplaced) @ level) / whole
    return level / whole * min(max(behind, 0.0), (1 - LEAST_WITHDRAWAL) * whole)


def press_down(sequence: MoveSequence, observation: Observation, load: float) -> MoveSequence:
    """The sequence with the opening lower or higher, as the trunk presses less or more than `PRESS` on the ground.

    Args:
        sequence: moves, the present one opening.
        observation: what is measured.
        load: weight that the trunk bears, negative where it presses down [N].
    """
    design, ground = observation.task.design, find_ground(observation)
    way = float(np.clip(-PRESS_STEP * (load + PRESS) / PRESS, -PRESS_STEP, PRESS_STEP))

    def shift(move: Move) -> Move:
        if move.action not in ("uncurl", "open") or move.rotation is None:
            return move
        height = float(move.position[2])
        least = min(height, ground + clear_height(design, move.rotation, CLEAR))
        return replace(move, position=np.array([*move.position[:2], max(height + way, least)]))

    return edit_moves(sequence, sequence.index, shift)


def right(sequence: MoveSequence, observation: Observation, height: float) -> MoveSequence:
    """The sequence with the remaining steps shifted against a lean that is seen, once only the hook holds the object.

    Before, the object leans as the wrap does. After the last step the trunk springs open, or the object is righted in
    one step more. From a wide object that stands by then it springs open at once.
    """
    camera, design, now = observation.camera, observation.task.design, sequence.move
    width = girth_width(observation.task.target, height)
    pull = _relative_pull(design, now.tension)
    if camera is None or pull > 1.02 * _loose_pull(design, width):
        return sequence
    if _is_wide_and_stands(observation, camera, width) and pull <= 1.02 * _find_last(observation, camera, width):
        return _end_opening(sequence)
    if sequence.moves[sequence.index + 1].action != "uncurl":
        last = sum(np.array_equal(move.tension, now.tension) for move in sequence.moves if move.action == "uncurl")
        if last > RIGHTINGS or abs(float(camera.axis[2])) > math.cos(UPRIGHT):
            return sequence
        sequence = insert_next(sequence, (replace(now, duration=RIGHTING_TIME),))
    return shift_later(sequence, RIGHT * righting(observation, camera))


def _end_opening(sequence: MoveSequence) -> MoveSequence:
    """The sequence without the steps of the opening that are left; the withdrawal ends as far off as it was to."""
    now, later = sequence.move, sequence.moves[sequence.index + 1 :]
    left = [move for move in later if move.action == "uncurl"]
    if not left:
        return sequence
    aside = (now.position - left[-1].position) * [1.0, 1.0, 0.0]
    drawn = next(move.position for move in later if move.action == "draw off")
    level = (drawn - left[-1].position) * [1.0, 1.0, 0.0]
    along = level / max(float(np.linalg.norm(level)), 1e-9)
    return _leave_from(sequence, now, aside - (aside @ along) * along)


def _leave_from(sequence: MoveSequence, last: Move, aside: np.ndarray, steps: tuple[Move, ...] = ()) -> MoveSequence:
    """The sequence with other steps of the opening, the trunk then let go where the last of them leaves the base.

    Args:
        sequence: moves, the present one before those steps.
        last: the last step.
        aside: displacement of the withdrawal, shape (3,) [m].
        steps: all that are still to come.
    """

    def follow(move: Move) -> Move:
        if move.action == "open":
            return replace(move, position=last.position, rotation=last.rotation)
        position = move.position + aside
        if move.action != "draw off":
            return replace(move, position=position)
        height = max(float(position[2]), float(last.position[2]))
        return replace(move, position=np.array([*position[:2], height]), rotation=last.rotation)

    later = (follow(move) for move in sequence.moves[sequence.index + 1 :] if move.action != "uncurl")
    return replace(sequence, moves=(*sequence.moves[: sequence.index + 1], *steps, *later))


def _plan_steps(
    sequence: MoveSequence, observation: Observation, camera: CameraObservation, width: float
) -> tuple[Move, ...]:
    """Steps of the opening: the hook goes from the leaning object to where the object stands upright on its edge."""
    design, now = observation.task.design, command_at(sequence, observation.time).T_world_base
    shut, half = float(shut_pull(design)[0]), observation.task.target.length / 2
    last = _find_last(observation, camera, width)
    pulls, n_eased = _choose_pulls(design, width, _relative_pull(design, observation.cable_tension), last)
    axis = camera.axis * math.copysign(1.0, float(camera.axis[2]))
    held = find_hook(design, width, now[:3, :3], pulls[0] * shut)
    hook = now[:3, 3] + held.center
    along = 2 * half * float(np.clip(0.5 + (hook - camera.position) @ axis / (2 * half), *BAND))
    leaning = camera.position + (along - half) * axis
    foot = camera.position + righting(observation, camera)
    upright = np.array([*foot[:2], find_ground(observation) + along])
    off = (leaning - hook) * [1.0, 1.0, 0.0]
    moves, rotation = [], now[:3, :3]
    duration = RUBBING_STEP_TIME if design.cable.friction > 0 else STEP_TIME
    for i, pull in enumerate(pulls[1:]):
        at = leaning + min(1.0, (i + 1) / n_eased) * (upright - leaning) - off
        rotation, position = _place_base(observation, width, pull * shut, (now[:3, :3], rotation), (held, axis, at))
        moves.append(wrap_move("uncurl", duration, position, cable_pulls(design, pull * shut, 0.0), rotation))
    return tuple(moves)


def _find_last(observation: Observation, camera: CameraObservation, width: float) -> float:
    """Pull from which the trunk springs open, over the one that shuts joint 1 [-]."""
    if not _is_wide_and_stands(observation, camera, width):
        return LAST
    return max(LAST, LAST_WIDE * _loose_pull(observation.task.design, width))


def _is_wide_and_stands(observation: Observation, camera: CameraObservation, width: float) -> bool:
    """Whether the tail does not close round the object, and it stands on the ground, by `LEAN_MOST`."""
    stands = is_on_ground(observation) and abs(float(camera.axis[2])) > math.cos(LEAN_MOST)
    return stands and width > WIDE * observation.task.design.length


def _choose_pulls(design: TrunkDesign, width: float, held: float, last: float) -> tuple[list[float], int]:
    """Pulls of the steps, the present one first, over the one that shuts joint 1, and how many until it is loose."""
    loose = _loose_pull(design, width)
    count = max(2, math.ceil((held - loose) / EASE))
    pulls = np.linspace(max(held, loose), loose, count + 1).tolist()
    while pulls[-1] * STEP > last:
        pulls.append(pulls[-1] * STEP)
    return [*pulls, *([last] if pulls[-1] > last else [])], count


def _place_base(
    observation: Observation,
    width: float,
    pull: float,
    rotations: tuple[np.ndarray, np.ndarray],
    held: tuple[Hook, np.ndarray, np.ndarray],
) -> tuple[np.ndarray, np.ndarray]:
    """Orientation [-] and position [m] of the base with the hook at a point, turned upright as far as there is room.

    Args:
        observation: what is measured.
        width: extent of the object across [m].
        pull: ventral pull [N].
        rotations: of the base at touch-down and at the step before.
        held: the hook at touch-down, the object's axis in it then, and where its centre is to be, [m].
    """
    design, ground, (first, before) = observation.task.design, find_ground(observation), rotations
    whole = _find_turn(design, width, pull, first, held)
    for part in np.linspace(1.0, 0.0, 6):
        way = Rotation.from_matrix((Rotation.from_rotvec(part * whole).as_matrix() @ first) @ before.T).as_rotvec()
        step = Rotation.from_rotvec(way * min(1.0, TURN / max(float(np.linalg.norm(way)), 1e-9)))
        rotation = step.as_matrix() @ before
        hook = find_hook(design, width, rotation, pull)
        position = held[2] - hook.center
        least = ground + max(-hook.lowest - SAG, clear_height(design, rotation, CLEAR))
        if position[2] >= least:
            break
    return rotation, np.array([*position[:2], max(float(position[2]), least)])


def _find_turn(
    design: TrunkDesign, width: float, pull: float, first: np.ndarray, held: tuple[Hook, np.ndarray, np.ndarray]
) -> np.ndarray:
    """Turn of the base that sets an object upright that moves with the hook, as a rotation vector, shape (3,) [rad]."""
    rotation = first
    for _ in range(2):  # The hook sags otherwise once the base has turned.
        hook = find_hook(design, width, rotation, pull)
        axis = _turn_between(held[0].normal, hook.normal).apply(held[1])
        rotation = _turn_between(axis, _UP).as_matrix() @ rotation
    return np.asarray(Rotation.from_matrix(rotation @ first.T).as_rotvec())


def _turn_between(start: np.ndarray, end: np.ndarray) -> Rotation:
    across = np.cross(start, end)
    sine = float(np.linalg.norm(across))
    return Rotation.from_rotvec(across / max(sine, 1e-12) * math.atan2(sine, float(start @ end)))


def _loose_pull(design: TrunkDesign, width: float) -> float:
    """Ventral pull at which only the hook holds an object, over the one that shuts joint 1 [-]."""
    shut = shut_pull(design)
    return max(LAST, CLOSE * float(shut[find_first(design, width, math.inf)] / shut[0]))


def _relative_pull(design: TrunkDesign, tension: np.ndarray) -> float:
    """Ventral pull of cable tensions over the one that shuts joint 1 [-]."""
    return float(tension @ -design.cable_direction[:, 1]) / float(shut_pull(design)[0])
