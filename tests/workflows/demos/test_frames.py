"""Frames: at a constant rate, and their actions are the commands."""

from __future__ import annotations

from types import ModuleType

import numpy as np
import pytest

from spiraltrunk.control.encoding import ControlMode, decode_action
from spiraltrunk.control.messages import Command
from spiraltrunk.errors import DesignError, UnknownName
from spiraltrunk.workflows.demos.options import RATES, RecordingOptions
from spiraltrunk.workflows.demos.recording.frames import choose_steps, encode_frames, read_arm_joints


@pytest.mark.parametrize("stride", [1, 2, 5, 50])
@pytest.mark.parametrize("mode", ["delta-pose-tension-pull", "pose-tension-pull", "delta-pose-pull"])
def test_actions_decoded_in_turn_are_the_commands(fakes: ModuleType, mode: str, stride: int) -> None:
    """No drift, however long: the last command before each frame comes back."""
    count = 403
    seen, commands = fakes.draw_messages(2, count)
    kind = ControlMode(mode)
    frames = encode_frames(seen, commands, [np.zeros(7)] * count, mode=kind, stride=stride)
    assert frames.clipped == 0
    task = seen[0].task
    before = Command(T_world_base=seen[0].T_world_base, cable_tension=np.zeros(3))
    steps = choose_steps(count, stride)
    assert len(frames) == len(steps) - 1 == -(-count // stride)
    assert len(frames.agent) == len(frames.environment) == len(steps)
    for step, action in zip(steps[1:], frames.action, strict=True):
        before = decode_action(kind, action, before, task, period=0.02 * stride)
        given = commands[step - 1]
        np.testing.assert_allclose(before.T_world_base, given.T_world_base, atol=2e-6)
        assert before.gripper == pytest.approx(given.gripper, abs=1e-6)
        if kind.sets_tension:
            np.testing.assert_allclose(before.cable_tension, given.cable_tension, atol=1e-5)
        if given.cable_pull is not None:
            np.testing.assert_allclose(before.cable_pull, given.cable_pull, atol=1e-7)


def test_joints_are_those_that_the_commands_lead_to(fakes: ModuleType) -> None:
    seen, commands = fakes.draw_messages(2, 20)
    arm = read_arm_joints(seen[0].task.design)
    led = list(np.random.default_rng(0).uniform(arm.low, arm.high, (20, 7)))
    frames = encode_frames(seen, commands, led, mode=ControlMode.JOINT_TENSION, stride=5)
    found = arm.low + (frames.action[:, :7] + 1) / 2 * (arm.high - arm.low)
    np.testing.assert_allclose(found, np.array(led)[[4, 9, 14, 19]], atol=1e-6)


def test_the_time_of_a_frame_is_exact(fakes: ModuleType) -> None:
    seen, commands = fakes.draw_messages(2, 23)
    for rate in RATES:
        steps = choose_steps(len(commands), 50 // rate)
        times = np.array([seen[step].time for step in steps])
        np.testing.assert_allclose(times[:-1], np.arange(len(times) - 1) / rate, atol=1e-12)
        assert steps[-1] == 23


@pytest.mark.parametrize(
    ("changes", "error", "told"),
    [
        ({"cameras": ("front", "back")}, UnknownName, "unknown camera 'back'; known: front, side, top, close"),
        ({"cameras": ("front", "front")}, DesignError, "each camera once"),
        ({"size": 8}, DesignError, "demos.size is 8; allowed: a whole number from 16 to 512"),
        ({"size": 97}, DesignError, "an even number"),
        ({"fps": 20}, DesignError, "demos.fps is 20; allowed: 1, 2, 5, 10, 25, 50: whole numbers of commands apart"),
        ({"fps": 0}, DesignError, "demos.fps is 0"),
        ({"mode": "delta"}, UnknownName, "unknown control mode 'delta'; known: delta-pose-tension"),
    ],
)
def test_impossible_recordings_are_refused(changes: dict[str, object], error: type[Exception], told: str) -> None:
    with pytest.raises(error) as caught:
        RecordingOptions(**changes)
    assert told in str(caught.value)
