"""States of a driver: no way from a fault to torque without a person, and arming only where nothing is in its way."""

from __future__ import annotations

import dataclasses
import math

import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, precondition, rule

from spiraltrunk.errors import DriveError
from spiraltrunk.hardware.motors.motor_port import MotorDataSheet, MotorState
from spiraltrunk.hardware.safety.fault import Fault, FaultKind
from spiraltrunk.hardware.safety.limits import SafetyLimits
from spiraltrunk.hardware.safety.states import (
    Mode,
    SafetyState,
    arm,
    clear,
    disarm,
    find_obstacles,
    finish_homing,
    latch,
    lose_count,
    start_homing,
)

SHEET = MotorDataSheet(
    name="test", torque_max=2.0, speed_max=30.0, torque_step=1e-4, angle_step=1e-3, period=1e-3, silence_max=0.1,
    temperature_derate=70.0, temperature_stop=90.0, rotor_inertia=1e-4, rotor_friction=0.02,
)  # fmt: skip
LIMITS = SafetyLimits()
GOOD = MotorState(time=10.0, angle=1.0, speed=0.0, torque=0.1, temperature=30.0)


def build_fault(kind: FaultKind = FaultKind.STALL, cable: int | None = 0, time: float = 1.0) -> Fault:
    return Fault(kind=kind, time=time, cable=cable, text="text")


def find(*motors: MotorState | None, now: float = 10.01, absence: str = "") -> tuple[str, ...]:
    return find_obstacles(motors, now, SHEET, LIMITS, absence=absence)


def test_nothing_is_in_the_way_of_fresh_cool_watched_motors():
    assert find(GOOD, GOOD) == ()


def test_each_obstacle_names_its_motor():
    assert find(GOOD, None) == ("motor 2: no feedback has come; check supply, bus and id",)
    assert "motor 1: the feedback is 60.0 ms old" in find(GOOD, now=10.06)[0]
    assert find(GOOD, now=10.0499) == ()
    assert len(find(GOOD, now=10.0501)) == 1
    assert find(GOOD, absence="its relay is open") == ("no watchdog is present: its relay is open",)
    warm = dataclasses.replace(GOOD, temperature=70.0)
    assert find(GOOD, warm) == ("motor 2 has 70 degC; allowed: below 70 degC",)
    assert find(dataclasses.replace(GOOD, temperature=69.9)) == ()
    assert "not finite" in find(dataclasses.replace(GOOD, angle=math.nan))[0]
    assert find(GOOD, dataclasses.replace(GOOD, problem="overload")) == (
        "motor 2: the motor reports a fault: overload; switch it off and on",
    )
    assert len(find(None, None, absence="there is none")) == 3


def test_arming_needs_homed_drums_and_no_obstacle():
    with pytest.raises(DriveError, match="cannot arm: the drums are not homed; home them first"):
        arm(SafetyState(), ())
    homed = finish_homing(start_homing(SafetyState(), ()))
    assert homed == SafetyState(is_homed=True)
    with pytest.raises(DriveError, match="cannot arm: one; two"):
        arm(homed, ("one", "two"))
    assert arm(homed, ()).mode is Mode.ARMED
    assert disarm(arm(homed, ())) == homed
    assert lose_count(homed) == SafetyState()
    assert lose_count(SafetyState()) == SafetyState()


def test_homing_needs_no_obstacle_and_forgets_the_old_zero():
    with pytest.raises(DriveError, match="cannot home: one"):
        start_homing(SafetyState(), ("one",))
    assert start_homing(SafetyState(is_homed=True), ()) == SafetyState(mode=Mode.HOMING)


@pytest.mark.parametrize("mode", list(Mode))
def test_events_are_refused_in_other_modes(mode):
    state = SafetyState(mode=mode, is_homed=True, faults=(build_fault(),) if mode is Mode.FAULT else ())
    events = {
        Mode.SAFE: [lambda: start_homing(state, ()), lambda: arm(state, ())],
        Mode.HOMING: [lambda: finish_homing(state)],
        Mode.ARMED: [lambda: disarm(state)],
        Mode.FAULT: [lambda: clear(state, "Ada", is_released=True)],
    }
    for allowed, calls in events.items():
        for call in calls:
            if allowed is mode:
                call()
            else:
                with pytest.raises(DriveError, match=f"the driver is in {mode.value}"):
                    call()


def test_torque_is_on_in_two_modes():
    assert [mode for mode in Mode if SafetyState(mode=mode).has_torque] == [Mode.HOMING, Mode.ARMED]


def test_the_first_cause_stays_and_each_is_kept_once():
    first, second = build_fault(), build_fault(FaultKind.BUS, None, 2.0)
    state = latch(SafetyState(mode=Mode.ARMED, is_homed=True), (first,))
    state = latch(state, (build_fault(time=3.0), second, build_fault(cable=1)))
    assert state.mode is Mode.FAULT
    assert state.faults == (first, second, build_fault(cable=1))
    assert state.is_homed
    assert latch(SafetyState(mode=Mode.ARMED), ()) == SafetyState(mode=Mode.ARMED)


@pytest.mark.parametrize("kind", FaultKind)
def test_a_fault_that_leaves_the_zeros_in_doubt_needs_homing_again(kind):
    stopped = latch(SafetyState(mode=Mode.ARMED, is_homed=True), (build_fault(FaultKind.STOPPED),))
    cleared = clear(latch(stopped, (build_fault(kind),)), "Ada", is_released=True)
    if kind.needs_homing:
        with pytest.raises(DriveError, match="home them first"):
            arm(cleared, ())
    else:
        assert arm(cleared, ()).mode is Mode.ARMED


@pytest.mark.parametrize("person", ["", "  ", "\x07", None, 3])
def test_a_fault_is_cleared_by_a_person_with_a_name(person):
    state = latch(SafetyState(), (build_fault(),))
    with pytest.raises(DriveError, match="allowed: the name of a person"):
        clear(state, person, is_released=True)


def test_a_fault_is_cleared_once_the_torque_is_off():
    state = latch(SafetyState(is_homed=True), (build_fault(),))
    with pytest.raises(DriveError, match="the torque is not off yet"):
        clear(state, "Ada", is_released=False)
    assert clear(state, " Ada ", is_released=True) == SafetyState(is_homed=True, cleared_by="Ada")


def test_a_refusal_in_fault_names_the_cause():
    with pytest.raises(DriveError, match=r"the driver is in fault \(stall: text\); allowed: in safe"):
        arm(latch(SafetyState(is_homed=True), (build_fault(),)), ())


class Machine(RuleBasedStateMachine):
    """Any sequence of events."""

    @initialize()
    def begin(self):
        self.state = SafetyState()
        self.was_cleared = True

    def attempt(self, event, *arguments, **options):
        before = self.state
        try:
            self.state = event(before, *arguments, **options)
        except DriveError:
            return
        if before.mode is Mode.FAULT and event not in {latch, lose_count}:
            assert event is clear, "only a person leads out of a fault"
            assert self.state.mode is Mode.SAFE

    @rule(obstacles=st.sampled_from([(), ("one",)]))
    def home(self, obstacles):
        self.attempt(start_homing, obstacles)
        assert not (obstacles and self.state.mode is Mode.HOMING) or not self.state.is_homed

    @rule(obstacles=st.sampled_from([(), ("one",)]))
    def arm(self, obstacles):
        before = self.state
        self.attempt(arm, obstacles)
        if self.state.mode is Mode.ARMED and before.mode is not Mode.ARMED:
            assert before.mode is Mode.SAFE
            assert before.is_homed
            assert not obstacles

    @rule()
    def finish(self):
        self.attempt(finish_homing)

    @rule()
    def disarm(self):
        self.attempt(disarm)

    @rule()
    def lose(self):
        self.attempt(lose_count)

    @rule(kind=st.sampled_from(FaultKind), cable=st.sampled_from([None, 0, 1]))
    def fail(self, kind, cable):
        first = self.state.faults[:1]
        self.attempt(latch, (build_fault(kind, cable),))
        assert self.state.mode is Mode.FAULT
        assert self.state.faults[:1] == (first or (build_fault(kind, cable),))

    @rule(person=st.sampled_from(["Ada", "", " "]), is_released=st.booleans())
    @precondition(lambda self: self.state.mode is Mode.FAULT)
    def clear(self, person, is_released):
        self.attempt(clear, person, is_released=is_released)
        assert (self.state.mode is Mode.SAFE) == (person == "Ada" and is_released)

    @invariant()
    def faults_are_there_exactly_in_fault(self):
        if hasattr(self, "state"):
            assert bool(self.state.faults) == (self.state.mode is Mode.FAULT)
            assert len(self.state.faults) <= 3 * len(FaultKind)
            if self.state.mode is Mode.ARMED:
                assert self.state.is_homed or self.state.has_torque


Machine.TestCase.settings = settings(max_examples=40, stateful_step_count=25)
TestMachine = Machine.TestCase
