"""Moves of the vertical wrap: what was risen for is taken back where the object is wrapped anew."""

from dataclasses import replace

import numpy as np
import pytest

from spiraltrunk.control.messages import Observation
from spiraltrunk.design.presets import PAPER
from spiraltrunk.sim.robot.trunk import TrunkOptions
from spiraltrunk.sim.scene.build import build_task
from spiraltrunk.sim.scene.options import SceneOptions
from spiraltrunk.strategies.moves import MoveSequence, base_position, begin, build_frame, insert_next, shift_later
from spiraltrunk.strategies.timing import travel_time
from spiraltrunk.strategies.wrap.hung import LEAD
from spiraltrunk.strategies.wrap.hung_plan import NEAR, OVERSHOOT, plan_wrap, wrap_again

SHIFT, BACK, UP = np.array([0.02, 0.0, 0.0]), np.array([0.0, -0.04, 0.0]), np.array([0.0, 0.0, 0.1])


def _observation() -> Observation:
    T_world_base = np.eye(4)
    T_world_base[:3, :3] = [[0, 0, 1], [0, -1, 0], [-1, 0, 0]]  # Hanging, dorsal side towards -y.
    return Observation(
        time=0.0, task=build_task(PAPER, SceneOptions()), T_world_base=T_world_base, arm_position=np.zeros(7),
        arm_velocity=np.zeros(7), cable_pull=np.zeros(3), cable_tension=np.zeros(3), base_force=np.zeros(3),
        base_torque=np.zeros(3),
    )  # fmt: skip


def _at(action: str) -> MoveSequence:
    observation = _observation()
    sequence = begin(plan_wrap(observation), observation)
    return replace(sequence, index=[move.action for move in sequence.moves].index(action))


def _risen() -> MoveSequence:
    hefted = _at("heft")
    rise = replace(hefted.move, action="rise on", position=hefted.move.position + UP)
    risen = insert_next(shift_later(hefted, UP, ("transport",)), (rise,))
    return replace(risen, index=risen.index + 1)


def _put_back_time(sequence: MoveSequence) -> float:
    """Duration of the way from the present move's end to where the object was wrapped [s]."""
    settled = next(move for move in sequence.moves if move.action == "settle")
    return travel_time(sequence.move.position - settled.position)


def test_a_wrap_after_a_second_rise_goes_on_as_after_the_first():
    """But for the time to put the object back from higher up."""
    first = wrap_again(_at("heft"), SHIFT, BACK)
    second = wrap_again(_risen(), SHIFT, BACK)
    later = first.moves[first.index + 1 :], second.moves[second.index + 1 :]
    assert [move.action for move in later[0]] == [move.action for move in later[1]]
    for one, other in zip(*later, strict=True):
        np.testing.assert_allclose(other.position, one.position, atol=1e-12)
    assert later[0][0].action == "put back"
    assert later[1][0].duration == pytest.approx(_put_back_time(_risen()))
    assert later[1][0].duration > later[0][0].duration


def test_a_wrap_tried_anew_moves_lift_and_carry_along_and_not_the_place():
    before = {move.action: move.position for move in _at("heft").moves}
    after = {move.action: move.position for move in wrap_again(_at("heft"), SHIFT, BACK).moves}
    for action, way in (("lift", SHIFT), ("hold", SHIFT), ("bring", 0.0 * SHIFT), ("lower", 0.0 * SHIFT)):
        np.testing.assert_allclose(after[action], before[action] + way, atol=1e-12)


def test_cables_in_step_can_pull_in_full():
    """The simulated winder gives way by less under its largest tension than one cable may be ahead."""
    lead = LEAD * PAPER.cable_stroke
    assert lead * TrunkOptions().cable_gain > PAPER.cable.tension_max


def test_the_object_touches_down_slowly():
    """A shut trunk is stiff: what touches the table at 80 mm/s may take the arm's joint 6 to its 12 N m."""
    sequence, length = _at("lower"), PAPER.length
    placing = sequence.move.position[2] + OVERSHOOT * length
    before = sequence.moves[sequence.index - 1]
    assert before.action == "bring"
    assert before.position[2] - placing == pytest.approx(NEAR * length)
    sequence = replace(
        sequence, start=replace(sequence.start, T_world_base=build_frame(before.position, before.rotation))
    )
    times = np.linspace(0.0, sequence.move.duration, 2001)
    height = np.array([base_position(sequence, time)[2] for time in times])
    speed = -np.gradient(height, times)
    assert speed[height > placing - 0.02].max() < 0.04
