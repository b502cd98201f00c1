"""What the two drivers over libfranka tell the device, and how they say that it is not well."""

from __future__ import annotations

import dataclasses
import sys
import threading

import numpy as np
import pytest
from arm_bench import HIGH, LOW, SETTINGS, SPEED, HandClock, Joints, make_bench

from spiraltrunk.errors import DriveError, MissingPackage
from spiraltrunk.hardware.arm.checks import COLLISION_FORCE, COLLISION_TORQUE
from spiraltrunk.hardware.arm.franky_arm import FrankyArm
from spiraltrunk.hardware.arm.open_within import open_within
from spiraltrunk.hardware.arm.panda_arm import PandaArm

DRIVERS = {"panda": (PandaArm, "panda_py", "panda-python"), "franky": (FrankyArm, "franky", "franky-control")}


@pytest.fixture(params=DRIVERS)
def name(request):
    return request.param


def test_a_missing_library_is_named_with_its_pip_line(name, monkeypatch):
    arm, module, package = DRIVERS[name]
    monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(MissingPackage, match=rf"pip install '{package}>="):
        arm("robot", SETTINGS, HandClock())


def test_thresholds_are_set_before_anything_moves(name, monkeypatch):
    joints = Joints()
    make_bench(name, monkeypatch, joints)
    told = [call for call in joints.calls if call[0] == "collision"]
    assert told == [("collision", list(COLLISION_TORQUE), list(COLLISION_FORCE))]
    assert joints.sent == []
    assert ("start",) not in joints.calls


def test_an_unreachable_arm_is_one_line_and_no_connection(name, monkeypatch):
    joints = Joints(is_gone=True)
    with pytest.raises(DriveError, match=r"arm 'robot' cannot be reached: libfranka: .*; is it on"):
        make_bench(name, monkeypatch, joints)
    assert joints.open_connections == 0


def test_a_silent_address_is_given_up_in_time():
    forever = threading.Event()
    try:
        with pytest.raises(DriveError, match=r"does not answer within 0.05 s"):
            open_within(0.05, "arm 'robot'", forever.wait)
    finally:
        forever.set()


@pytest.mark.parametrize("mode", [0, 3, 4, 5, 6])
def test_an_arm_that_is_not_ready_is_not_opened(name, mode, monkeypatch):
    joints = Joints(mode=mode)
    with pytest.raises(DriveError, match=r"the arm reports .* allowed: an arm that stands ready"):
        make_bench(name, monkeypatch, joints)
    assert joints.open_connections == 0


def test_a_reflex_is_told_and_nothing_is_sent_after_it(name, monkeypatch):
    joints = Joints()
    bench = make_bench(name, monkeypatch, joints)
    bench.step(np.full(7, 0.02), 10)
    joints.mode, joints.errors = 4, {"joint_reflex"}
    sent = bench.sent()
    assert bench.arm.read().error == "the arm reports reflex, joint_reflex"
    bench.arm.send(bench.arm.read().position)
    assert bench.sent() == sent
    joints.mode, joints.errors = 1, set()  # Cleared by somebody; the port still wants to be opened anew.
    assert bench.arm.read().error == "the arm reports reflex, joint_reflex"
    bench.arm.hold()
    bench.arm.close()


def test_frozen_feedback_is_told(name, monkeypatch):
    bench = make_bench(name, monkeypatch)
    bench.arm.read()
    bench.clock.time += 0.04
    assert bench.arm.read().error is None
    bench.clock.time += 0.02
    assert "feedback is 60 ms old; allowed: 50 ms" in bench.arm.read().error


@pytest.mark.parametrize("part", ["position", "velocity", "acceleration", "torque"])
@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_each_part_of_a_measurement_must_be_finite(name, part, value, monkeypatch):
    bench = make_bench(name, monkeypatch)
    good = bench.arm.read()
    measured = dataclasses.replace(bench.arm._measure(), **{part: np.array([*np.zeros(6), value])})
    monkeypatch.setattr(bench.arm, "_measure", lambda: measured)
    state = bench.arm.read()
    assert "not finite" in state.error
    assert np.array_equal(getattr(state, part), getattr(good, part))


def test_numbers_that_are_none_are_told(name, monkeypatch):
    joints = Joints()
    bench = make_bench(name, monkeypatch, joints)
    good = bench.arm.read().position
    joints.q = joints.q * np.nan
    bench.advance(0.01)
    state = bench.arm.read()
    assert "not finite" in state.error
    np.testing.assert_array_equal(state.position, good)


def test_an_unreadable_command_library_never_raises_in_the_loop(name, monkeypatch):
    joints = Joints()
    bench = make_bench(name, monkeypatch, joints)
    position = bench.arm.read().position
    monkeypatch.setattr(joints, "follow", lambda target: (_ for _ in ()).throw(RuntimeError("move rejected")))
    bench.arm.send(position)
    assert bench.arm.read().error == "move rejected"


def test_the_end_effector_set_in_desk_counts_towards_the_payload(name, monkeypatch):
    from arm_contract import LOAD

    bench = make_bench(name, monkeypatch, Joints(tool_mass=1.6))
    with pytest.raises(DriveError, match=r"1.5 kg and 1.6 kg of end effector"):
        bench.arm.set_load(LOAD)


def test_the_connection_is_released(name, monkeypatch):
    joints = Joints()
    bench = make_bench(name, monkeypatch, joints)
    bench.step(np.full(7, 0.02), 10)
    assert joints.open_connections == 1
    bench.arm.close()
    assert joints.open_connections == 0


def test_the_arms_own_range_counts(monkeypatch):
    wide = dataclasses.replace(SETTINGS.limits, position=(LOW - 1, HIGH + 1))
    monkeypatch.setattr("arm_bench.SETTINGS", dataclasses.replace(SETTINGS, limits=wide))
    np.testing.assert_array_equal(make_bench("panda", monkeypatch).arm.limits.position, (LOW, HIGH))


def test_holding_again_commands_nothing(name, monkeypatch):
    bench = make_bench(name, monkeypatch)
    bench.step(np.full(7, 0.02), 10)
    bench.arm.hold()
    before = bench.sent()
    for _ in range(5):
        bench.advance(0.02)
        bench.arm.hold()
    assert bench.sent() == before


@pytest.fixture(params=["kinematic", *DRIVERS])
def moving(request, monkeypatch):
    """A bench whose joints have just got a target that they have not reached, after they were held once before."""
    joints = Joints()
    bench = make_bench(request.param, monkeypatch, joints)
    bench.step(np.full(7, 0.02), 10)
    bench.arm.hold()
    bench.advance(0.02)
    bench.arm.send(bench.arm.read().position + 0.02)
    assert not np.array_equal(joints.target, joints.q)
    return bench, joints


def test_hold_stops_each_new_motion(moving):
    bench, joints = moving
    bench.arm.hold()
    np.testing.assert_array_equal(joints.target, joints.q)


def test_close_stops_the_motion(moving):
    bench, joints = moving
    bench.arm.close()
    np.testing.assert_array_equal(joints.target, joints.q)


def test_targets_do_not_run_away_from_an_arm_that_is_blocked(moving):
    bench, joints = moving
    bench.arm.hold()
    here = joints.q.copy()
    lead = np.zeros(7)
    step = 0.061 * SETTINGS.period * SPEED[0]
    sent = bench.sent()
    with pytest.raises(DriveError, match=r"joint 1 is .* blocks the arm"):  # noqa: PT012 (which step, is the matter)
        for _ in range(200):
            joints.time += SETTINGS.period
            bench.clock.time += SETTINGS.period
            lead[0] += step
            bench.arm.send(here + lead)
    assert bench.sent() - sent == int(SETTINGS.lead_time * SPEED[0] / step)
