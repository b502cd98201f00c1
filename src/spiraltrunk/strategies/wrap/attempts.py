"""Attempts of a standing wrap: what the closing trunk presses on, the test of the load, and the second try."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from spiraltrunk.control.messages import Observation
from spiraltrunk.strategies.moves import (
    PHASES,
    Move,
    MoveSequence,
    advance,
    allow_time,
    base_position,
    edit_moves,
    insert_next,
    shift_later,
)
from spiraltrunk.strategies.wrap.standing_plan import ACCELERATION, TEST

# All of these are ours, tuned in simulated trials.
RISES = 2
"""Number of further rises of one test of the load [-]. A trunk that closes low presses the object on the ground, by up
to 10 N in simulated trials: the first rise only relieves it, and its wrap sags by as much."""
RISE_TIME = 1.0
"""Duration of a further rise [s]."""
DRAW_OFF_TIME = 2.0
"""Time in which the open trunk draws off the object before a second try [s], as in the release: in half of it, the tail
drags the object over."""
PRESS = 8.0
"""Force by which the trunk may press down as it closes [N]: one on a handle or a rim presses with 50 N."""
YIELD = 0.0004
"""Rise of the base at each reading of a larger force [m]: 20 mm/s."""
JAMMED = 10.0
"""Force on the base from which a distal wrap closes without moving the arm further [N] (ours): what is wide and short
jams between the thick sections and the ground, and the arm's wrist would press with 60 to 140 N, its torque limit."""
CUT = 0.015
"""Rise that a lift lacks where its corner with the carry is rounded and the arm lags [m] (ours)."""
SAG_MOST = 0.02
"""Most by which a sagging object is lifted further [m] (ours)."""


def go_on(sequence: MoveSequence, observation: Observation) -> MoveSequence:
    """Begin the next move, which lasts as long as the arm needs."""
    return advance(allow_time(sequence, observation.time, *ACCELERATION), observation.time)


def yield_upwards(sequence: MoveSequence) -> MoveSequence:
    """The sequence with the present move and the remaining ones before the release higher by YIELD."""
    up, i = np.array([0.0, 0.0, YIELD]), sequence.index
    higher = shift_later(sequence, up, PHASES[:3])
    here = replace(sequence.move, position=sequence.move.position + up)
    return replace(higher, moves=(*higher.moves[:i], here, *higher.moves[i + 1 :]))


def is_jammed(observation: Observation, free: float) -> bool:
    """Whether the base is pushed by more than JAMMED; ``free`` is the weight before the object was touched [N]."""
    return float(np.linalg.norm(observation.base_force + np.array([0.0, 0.0, free]))) > JAMMED


def tighten_here(sequence: MoveSequence, time: float) -> MoveSequence:
    """The sequence with the rest of the curl left out, and all moves before the release shifted to the base's place."""
    i = next(k for k, move in enumerate(sequence.moves) if k > sequence.index and move.action == "tighten")
    short = replace(sequence, moves=(*sequence.moves[: sequence.index + 1], *sequence.moves[i:]))
    return shift_later(short, base_position(sequence, time) - sequence.moves[i].position, PHASES[:3])


def stay_here(sequence: MoveSequence, observation: Observation) -> MoveSequence:
    """The sequence with the remaining moves shifted up to the present height."""
    rise = base_position(sequence, observation.time)[2] - sequence.move.position[2]
    return shift_later(sequence, np.array([0.0, 0.0, rise]))


def may_rise(sequence: MoveSequence) -> bool:
    """Whether the present test of the load has risen further less often than RISES."""
    return _count_rises(sequence) < RISES


def rise_further(sequence: MoveSequence) -> MoveSequence:
    """The sequence with one more rise of the test of the load after the present one."""
    here = sequence.move
    higher = replace(here, duration=RISE_TIME, position=here.position + np.array([0.0, 0.0, TEST]))
    return insert_next(sequence, (higher,))


def carry_higher(sequence: MoveSequence) -> MoveSequence:
    """The sequence with the remaining moves before the release as much higher as the test of the load has risen."""
    return shift_later(sequence, np.array([0.0, 0.0, _count_rises(sequence) * TEST]), PHASES[:3])


def lift_further(sequence: MoveSequence, observation: Observation, stood: float) -> MoveSequence:
    """The sequence lifted by what its corner takes, and by what the object, as a camera sees it, has risen too little.

    Args:
        sequence: moves, the present one before the lift.
        observation: what is seen.
        stood: height of the object's centre as the camera saw it stand [m].
    """
    sag = 0.0
    if observation.camera is not None:
        done = [move.action for move in sequence.moves[: sequence.index]]
        since_tight = done[-done[::-1].index("tighten") :]
        lost = TEST * since_tight.count("try") - (float(observation.camera.position[2]) - stood)
        sag = min(SAG_MOST, max(0.0, lost))
    longer = 1.0 + (CUT + sag) / observation.task.goal.lift  # The speed stays as it was.
    slower = edit_moves(
        sequence, sequence.index + 1,
        lambda move: replace(move, duration=longer * move.duration) if move.action == "lift" else move,
    )  # fmt: skip
    return shift_later(slower, np.array([0.0, 0.0, CUT + sag]), PHASES[2:3])


def try_again(sequence: MoveSequence) -> tuple[Move, ...]:
    """Set down, spring open as in the release, back off, come near, and repeat the moves since the touch."""
    done = sequence.moves[: sequence.index + 1]
    last = {move.action: i for i, move in enumerate(done)}
    release = [move for move in sequence.moves if move.phase == "release"]
    n_eased = sum(move.action == "uncurl" for move in release)
    again = sequence.moves[last["touch"] : sequence.index + 1 - _count_rises(sequence)]
    back = [_let_go(move) for move in reversed(again) if move.action != "try"][: n_eased + 1]
    spring = [
        replace(_let_go(move), phase="prehension", position=back[-1].position, rotation=back[-1].rotation)
        for move in release
        if move.action == "open"
    ]
    first = replace(_let_go(again[0]), duration=DRAW_OFF_TIME)
    apart = replace(sequence.moves[last["descend"]], phase="prehension", action="back off", duration=2.0)
    return (*back, *spring, first, apart, sequence.moves[last["near"]], *again)


def _count_rises(sequence: MoveSequence) -> int:
    """Number of moves right before the present one that bear its name."""
    done = [move.action for move in sequence.moves[: sequence.index + 1]]
    return next((i for i, action in enumerate(reversed(done)) if action != done[-1]), len(done)) - 1


def _let_go(move: Move) -> Move:
    return replace(move, action="let go", milestone=None)
