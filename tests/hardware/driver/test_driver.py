"""The driver's loop on motors of a few lines: arming, refusals, faults, reaction, watchdog, close."""

from __future__ import annotations

import dataclasses
import math
import types

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from spiraltrunk.control.arm_limits import ArmLimits
from spiraltrunk.design import presets
from spiraltrunk.design.drum import size_drum
from spiraltrunk.errors import DriveError
from spiraltrunk.hardware.arm.arm_port import ArmLoad, ArmPort, ArmState
from spiraltrunk.hardware.clock import Clock
from spiraltrunk.hardware.driver.homing_routine import HomingRoutine, HomingStep
from spiraltrunk.hardware.driver.options import DriverOptions
from spiraltrunk.hardware.driver.trunk_driver import TrunkDriver
from spiraltrunk.hardware.motors.motor_port import MotorDataSheet, MotorPort, MotorState
from spiraltrunk.hardware.motors.pwm_servo import ServoCalibration
from spiraltrunk.hardware.motors.servo_port import ServoPort
from spiraltrunk.hardware.safety.fault import FaultKind
from spiraltrunk.hardware.safety.reaction import LET_GO_TIME
from spiraltrunk.hardware.safety.states import Mode
from spiraltrunk.hardware.safety.watchdog import Watchdog
from spiraltrunk.hardware.winder.drum import DrumGeometry
from spiraltrunk.hardware.winder.winder import build_winder

SHEET = MotorDataSheet(
    name="test", torque_max=2.0, speed_max=33.0, torque_step=1e-4, angle_step=7.7e-4, period=1e-3, silence_max=0.1,
    temperature_derate=70.0, temperature_stop=90.0, rotor_inertia=1.5e-4, rotor_friction=0.02,
)  # fmt: skip
DT = 0.002
DESIGN = presets.get("paper")
DRUM = DrumGeometry(design=size_drum(DESIGN))


class FakeClock(Clock):
    time = 0.0

    def now(self) -> float:
        return self.time

    def sleep_until(self, moment: float) -> None:
        self.time = max(self.time, moment)


class FakeMotors(MotorPort):
    """Rotors on a trunk of 400 N/m in bending and 8000 N/m in compression, damped, taut at 0; they hold torques."""

    def __init__(self, clock: FakeClock, n_motor: int = 3) -> None:
        self.data_sheet, self.n_motor, self._clock = SHEET, n_motor, clock
        self.angle, self.speed, self.torque = ([0.0] * n_motor for _ in range(3))
        self.temperature = [30.0] * n_motor
        self.sent: list[tuple[float, tuple[float, ...]]] = []
        self.is_bus_off = self.is_silent = self.is_lost = self.is_closed = False
        self.held = (None,) * n_motor

    def read(self):
        self._check()
        if not self.is_silent:
            self.held = tuple(map(self._show, range(self.n_motor)))
        return self.held

    def _show(self, i: int) -> MotorState:
        self._advance(i)
        return MotorState(
            time=self._clock.time, angle=round(self.angle[i] / 7.7e-4) * 7.7e-4, speed=self.speed[i],
            torque=self.torque[i], temperature=self.temperature[i], is_count_lost=self.is_lost,
        )  # fmt: skip

    def _advance(self, i: int) -> None:
        radius, inertia = DRUM.design.winding_radius, 1.5e-4
        for _ in range(4):
            mean = sum(self.angle) / self.n_motor
            force = 400.0 * (self.angle[i] - mean) + 8000.0 * mean + 60.0 * self.speed[i]
            tension = max(0.0, radius * force)
            self.speed[i] += DT / 4 / inertia * (self.torque[i] - radius * tension)
            rub = min(abs(self.speed[i]), DT / 4 / inertia * 0.02)
            self.speed[i] -= math.copysign(rub, self.speed[i])
            self.angle[i] += DT / 4 * self.speed[i]

    def send(self, torques) -> None:
        self._check()
        assert all(math.isfinite(torque) and abs(torque) <= 2.0 for torque in torques)
        self.torque = list(torques)
        self.sent.append((self._clock.time, tuple(torques)))

    def _check(self) -> None:
        if self.is_bus_off:
            raise DriveError("the bus is off")

    def restart_count(self) -> None:
        self.is_lost = False

    def close(self) -> None:
        self.is_closed = True


class FakeWatchdog(Watchdog):
    def __init__(self) -> None:
        self.n_fed, self.is_there, self.n_cleared, self.is_gone, self.n_ended = 0, True, 0, False, 0

    def feed(self) -> None:
        if self.is_gone:
            raise DriveError("the relay is gone")
        self.n_fed += 1

    def find_absence(self) -> str:
        return "" if self.is_there else "its relay is open"

    def clear(self) -> None:
        self.n_cleared += 1
        self.is_there = True

    def end(self) -> None:
        self.n_ended += 1


class FakeArm(ArmPort):
    def __init__(self, clock: FakeClock) -> None:
        bounds = (np.full(7, -2.0), np.full(7, 2.0))
        self.limits = ArmLimits(position=bounds, velocity=None, acceleration=None, jerk=None, torque=None)
        self._clock, self.sent, self.n_held, self.age, self.error = clock, [], 0, 0.0, None
        self.refusal, self.is_gone, self.is_closed, self.position = "", False, False, np.zeros(7)

    def read(self) -> ArmState:
        if self.is_gone:
            raise DriveError("the arm is gone")
        zeros = np.zeros(7)
        return ArmState(
            time=self._clock.time - self.age, position=self.position, velocity=zeros, acceleration=zeros, torque=zeros,
            error=self.error,
        )  # fmt: skip

    def set_load(self, load: ArmLoad) -> None: ...

    def send(self, position: np.ndarray) -> None:
        if self.refusal:
            raise DriveError(self.refusal)
        self.sent.append(position)

    def hold(self) -> None:
        self.n_held += 1
        if self.is_gone:
            raise DriveError("the arm is gone")

    def close(self) -> None:
        self.is_closed = True


class FakeServo(ServoPort):
    def __init__(self) -> None:
        self.pulses, self.n_released, self.is_gone = [], 0, False

    def set_pulse(self, pulse_us: float) -> None:
        if self.is_gone:
            raise DriveError("the servo is gone")
        self.pulses.append(pulse_us)

    def release(self) -> None:
        self.n_released += 1


class AtOnce(HomingRoutine):
    """Homed where the motors are."""

    def start(self, motors) -> None: ...

    def step(self, motors, now, dt) -> HomingStep:
        return HomingStep((0.0,) * len(motors), tuple(motor.angle for motor in motors))


class Rig(types.SimpleNamespace):
    """A driver and its fakes."""

    def run(self, seconds: float, each=lambda rig: None) -> None:
        for _ in range(round(seconds / DT)):
            each(self)
            self.driver.wait()
            self.driver.tick()

    def aim(self, tension=(5.0, 5.0, 5.0), **others) -> None:
        self.driver.set_targets(tension, **{"valid_for": DT, **others})

    def ready(self) -> Rig:
        """Homed and armed."""
        self.run(0.05)
        self.driver.home()
        self.run(0.5)
        assert self.driver.is_homed, self.driver.faults
        self.driver.arm()
        return self

    def pull(self, seconds: float = 0.5) -> Rig:
        """Armed, and pulled at 5 N."""
        self.ready().run(seconds, Rig.aim)
        assert self.driver.mode is Mode.ARMED, self.driver.faults
        return self

    @property
    def kinds(self):
        return [fault.kind for fault in self.driver.faults]

    def torques_since(self, time: float):
        return [(at - time, torques) for at, torques in self.motors.sent if at >= time - 1e-9]


def build(*, with_sides: bool = False, options: DriverOptions | None = None, homing=None) -> Rig:
    clock = FakeClock()
    motors, watchdog = FakeMotors(clock), FakeWatchdog()
    winders = [build_winder(DESIGN, SHEET, DRUM, DT) for _ in range(3)]
    arm, servo = (FakeArm(clock), FakeServo()) if with_sides else (None, None)
    driver = TrunkDriver(
        design=DESIGN, motors=motors, winders=winders, watchdog=watchdog, clock=clock, servo=servo, arm=arm,
        homing=homing or AtOnce(), options=options,
    )  # fmt: skip
    return Rig(driver=driver, motors=motors, watchdog=watchdog, clock=clock, arm=arm, servo=servo)


@pytest.fixture
def rig() -> Rig:
    return build()


# Nominal.


def test_without_torque_zeros_are_sent_in_every_period(rig):
    rig.run(0.1)
    assert {torques for _, torques in rig.motors.sent} == {(0.0, 0.0, 0.0)}
    assert len(rig.motors.sent) == 50 == rig.watchdog.n_fed
    assert rig.driver.mode is Mode.SAFE


def test_arming_holds_the_floor_and_targets_pull(rig):
    rig.ready().run(0.5)
    assert rig.driver.mode is Mode.ARMED
    floor = rig.driver.snapshot().cables[0].tension_target
    assert 1.0 <= floor < 2.0
    rig.run(1.0, lambda one: one.aim((10.0, 0.0, 20.0)))
    assert rig.driver.mode is Mode.ARMED, rig.driver.faults
    tensions = [cable.tension for cable in rig.driver.snapshot().cables]
    assert tensions == pytest.approx([10.0, floor, 20.0], abs=2.5)


@pytest.mark.slow
def test_10_s_of_nominal_running_raise_nothing(rig):
    def swing(one):
        t = one.clock.time
        one.aim([max(0.0, 12.0 + 18.0 * math.sin(2.0 * t + k)) for k in range(3)])

    rig.ready().run(10.0, swing)
    assert rig.driver.mode is Mode.ARMED, rig.driver.faults


def test_disarming_lets_go_slowly_and_ends_safe(rig):
    rig.pull()
    rig.driver.disarm()
    start = rig.clock.time
    with pytest.raises(DriveError, match="no targets are taken in armed"):
        rig.aim()
    rig.run(LET_GO_TIME + 0.01)
    assert rig.driver.mode is Mode.SAFE
    assert not rig.driver.faults
    sizes = [max(torques) for _, torques in rig.torques_since(start)]
    assert sizes == sorted(sizes, reverse=True)
    assert sizes[-1] == 0.0
    rig.driver.arm()


def test_the_snapshot_tells_what_there_is(rig):
    before = rig.driver.snapshot()
    assert before.cables[0].feedback_age == math.inf
    assert math.isnan(before.cables[0].temperature)
    assert math.isnan(before.cables[0].torque)
    assert before.cables[0].torque_sent == 0.0
    assert before.lateness.n_period == 0
    rig.pull()
    shown = rig.driver.snapshot()
    assert (shown.mode, shown.is_homed, shown.is_letting_go, shown.is_watched) == (Mode.ARMED, True, False, True)
    assert shown.cables[1].pull == pytest.approx(DRUM.design.winding_radius * rig.motors.angle[1], abs=1e-3)
    assert shown.cables[1].tension_target == 5.0
    assert shown.cables[1].torque_sent == rig.motors.torque[1] != 0.0
    assert shown.lateness.n_period == len(rig.motors.sent)
    assert shown.lateness.p999 == 0.0


def test_the_snapshot_tells_the_motors_own_torque_beside_the_one_that_was_sent(rig):
    rig.pull()
    show = rig.motors._show
    rig.motors._show = lambda i: dataclasses.replace(show(i), torque=0.01 * i)
    rig.aim()
    rig.run(DT)
    shown = rig.driver.snapshot().cables
    assert [cable.torque for cable in shown] == [0.0, 0.01, 0.02]
    assert [cable.torque_sent for cable in shown] == rig.motors.torque
    assert min(rig.motors.torque) > 0.03


# Arming.


def test_arming_is_refused_with_every_reason():
    rig = build()
    rig.motors.is_silent = True
    rig.watchdog.is_there = False
    rig.run(0.02)
    with pytest.raises(DriveError, match=r"not homed.*no watchdog.*motor 1: no feedback.*motor 3: no feedback"):
        rig.driver.arm()
    with pytest.raises(DriveError, match="cannot home: no watchdog"):
        rig.driver.home()
    assert rig.driver.mode is Mode.SAFE


def test_without_a_watchdog_only_when_told_so():
    rig = build(options=DriverOptions(without_watchdog=True))
    rig.watchdog.is_there = False
    rig.pull()
    assert rig.driver.mode is Mode.ARMED


def test_a_lost_count_needs_homing_again(rig):
    rig.ready()
    rig.driver.disarm()
    rig.run(LET_GO_TIME + 0.01)
    rig.motors.is_lost = True
    rig.run(0.01)
    with pytest.raises(DriveError, match="the drums are not homed"):
        rig.driver.arm()


def test_the_period_is_at_least_the_buss():
    with pytest.raises(DriveError, match="at least 1 ms, that of the test's bus"):
        build(options=DriverOptions(period=0.0009))


def test_one_motor_and_one_winder_for_each_cable():
    clock = FakeClock()
    with pytest.raises(DriveError, match="2 motors and 0 winders for 3 cables"):
        TrunkDriver(
            design=DESIGN, motors=FakeMotors(clock, 2), winders=[], watchdog=FakeWatchdog(), clock=clock
        )  # fmt: skip


# Hostile commands.

HOSTILE = [
    {"tension": (math.nan, 1, 1)}, {"tension": (1, math.inf, 1)}, {"tension": (1, 1, -math.inf)},
    {"tension": (1, 1)}, {"tension": (1, 1, 1, 1)}, {"tension": 1.0}, {"tension": None}, {"tension": "111"},
    {"tension": (-0.1, 1, 1)}, {"tension": (60.1, 1, 1)}, {"tension": (1e300, 1, 1)}, {"tension": [[1, 1, 1]]},
    {"tension": (1j, 1, 1)}, {"tension": ([1], 1, 1)}, {"tension": {}}, {"tension": (10**400, 1, 1)},
    {"pull": (math.nan, 0, 0)}, {"pull": (-math.inf, 0, 0)}, {"pull": (-101.0, 0, 0)}, {"pull": (0, 0)},
    {"pull": "far"}, {"pull": math.inf},
    {"gripper": math.nan}, {"gripper": 1.1}, {"gripper": -1.1}, {"gripper": (0, 0)}, {"gripper": "open"},
    {"valid_for": math.nan}, {"valid_for": math.inf}, {"valid_for": -0.001}, {"valid_for": 1.1}, {"valid_for": None},
    {"arm_position": (math.nan, *[0] * 6)}, {"arm_position": (math.inf, *[0] * 6)}, {"arm_position": [0] * 6},
    {"arm_position": (0, 0, 2.1, 0, 0, 0, 0)}, {"arm_position": (0, 0, -2.1, 0, 0, 0, 0)}, {"arm_position": "home"},
]  # fmt: skip


def attack(rig: Rig, **bad) -> None:
    """A command that must be refused, and change nothing."""
    before = rig.driver.snapshot()
    with pytest.raises(DriveError) as caught:
        rig.driver.set_targets(**{"tension": (1.0, 1.0, 1.0), "valid_for": 0.5, **bad})
    assert "\n" not in str(caught.value)
    after = rig.driver.snapshot()
    assert after.cables == before.cables
    assert after.gripper == before.gripper
    assert after.n_refused == before.n_refused + 1


def test_every_hostile_command_is_refused_and_renews_nothing():
    rig = build(with_sides=True).pull()
    for bad in HOSTILE:
        attack(rig, **bad)
        rig.aim()
        rig.run(DT)
    assert rig.driver.mode is Mode.ARMED
    assert rig.arm.sent == []
    rig.run(0.06, lambda one: one.driver.mode is Mode.ARMED and attack(one, **HOSTILE[0]))
    assert rig.kinds[0] is FaultKind.BAD_COMMAND
    assert "tension is nan" in rig.driver.faults[0].text


anything = st.one_of(
    st.floats(), st.integers(), st.text(max_size=3), st.none(), st.booleans(),
    st.lists(st.one_of(st.floats(), st.integers(), st.none(), st.text(max_size=2)), max_size=5),
)  # fmt: skip


@pytest.fixture(scope="module")
def armed_rig() -> Rig:
    return build(with_sides=True).pull()


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow], max_examples=100)
@given(name=st.sampled_from(["tension", "pull", "arm_position", "gripper", "valid_for"]), value=anything)
def test_whatever_is_accepted_is_finite_and_in_range(armed_rig, name, value):
    rig = armed_rig
    rig.aim()
    try:
        rig.driver.set_targets(**{"tension": (1.0, 1.0, 1.0), "valid_for": DT, name: value})
    except DriveError:
        pass
    else:
        targets = rig.driver._loop.targets
        assert all(0.0 <= one <= 60.0 for one in targets.tension)
        assert len(targets.tension) == len(targets.pull) == 3
        assert all(one > -100.0 for one in targets.pull)
        assert -1.0 <= targets.gripper <= 1.0
        assert rig.clock.time <= targets.expires <= rig.clock.time + 1.0
        assert targets.arm_position is None or (np.abs(targets.arm_position) <= 2.0).all()
    rig.aim()
    rig.run(DT)
    assert rig.driver.mode is Mode.ARMED


def test_what_has_no_arm_and_no_servo_takes_no_command_for_them(rig):
    rig.pull()
    attack(rig, arm_position=[0.0] * 7)
    attack(rig, gripper=0.5)
    assert rig.driver.mode is Mode.ARMED


def test_no_targets_are_taken_unless_armed(rig):
    rig.run(0.1)
    with pytest.raises(DriveError, match="no targets are taken in safe; arm the driver first"):
        rig.aim()


# Faults and the reaction.


def check_reaction(rig: Rig, start: float, kind: FaultKind, *, within: float = 0.1) -> None:
    """The first fault is that; torques fall from there on, are zero in time and stay so."""
    rig.run(0.3)
    assert rig.driver.mode is Mode.FAULT
    assert rig.kinds[0] is kind, rig.driver.faults
    found = rig.driver.faults[0].time
    since = rig.torques_since(found)
    last = [torques for at, torques in rig.motors.sent if at <= found][-1]
    sizes = [max(map(abs, torques)) for _, torques in since]
    assert all(then <= first + 1e-12 for first, then in zip([max(last), *sizes], sizes, strict=False))
    assert all(torques == (0.0, 0.0, 0.0) for at, torques in since if at + found - start >= within)
    with pytest.raises(DriveError, match="no targets are taken in fault"):
        rig.aim()
    with pytest.raises(DriveError, match="the driver is in fault"):
        rig.driver.arm()


def test_a_command_that_is_not_renewed_is_stale_after_20_ms(rig):
    start = rig.pull().clock.time
    check_reaction(rig, start, FaultKind.STALE_COMMAND)
    assert rig.driver.faults[0].time - start == pytest.approx(0.020, abs=2 * DT)


def test_a_command_is_valid_for_as_long_as_it_says(rig):
    rig.pull()
    rig.aim(valid_for=0.5)
    rig.run(0.51)
    assert rig.driver.mode is Mode.ARMED
    rig.run(0.02)
    assert rig.kinds == [FaultKind.STALE_COMMAND]


def test_twenty_missed_periods_reach_the_safe_state_within_100_ms(rig):
    start = rig.pull().clock.time
    rig.motors.is_silent = True
    rig.run(0.04, Rig.aim)
    check_reaction(rig, start, FaultKind.STALE_FEEDBACK)


def test_a_persons_stop_ramps_within_40_ms_and_is_never_refused(rig):
    start = rig.pull().clock.time
    rig.driver.stop()
    check_reaction(rig, start, FaultKind.STOPPED, within=0.045)
    rig.driver.stop()
    rig.driver.clear_fault("Ada")
    rig.driver.stop()
    assert rig.kinds == [FaultKind.STOPPED]


def test_a_hot_motor_is_derated_and_then_stops(rig):
    rig.pull()
    rig.run(1.0, lambda one: one.aim((30.0, 30.0, 30.0)))
    rig.motors.temperature[1] = 85.0
    rig.run(1.0, lambda one: one.aim((30.0, 30.0, 30.0)))
    shown = rig.driver.snapshot()
    assert shown.mode is Mode.ARMED, shown.faults
    assert shown.cables[1].tension < 18.0 < 25.0 < shown.cables[0].tension
    assert "motor 2 has 85 degC" in shown.warnings[0]
    start = rig.clock.time
    rig.motors.temperature[1] = 90.0
    rig.aim()
    check_reaction(rig, start, FaultKind.OVER_TEMPERATURE)
    assert rig.driver.faults[0].cable == 1


def test_after_a_bus_returns_no_stale_torque_is_sent_and_the_watchdog_was_not_fed(rig):
    start = rig.pull().clock.time
    rig.motors.is_bus_off = True
    rig.run(0.05)
    n_fed = rig.watchdog.n_fed
    rig.run(0.2)
    assert rig.watchdog.n_fed == n_fed, "the watchdog has to end the torque"
    rig.motors.is_bus_off = False
    rig.run(0.1)
    assert rig.kinds[0] is FaultKind.BUS
    assert {torques for _, torques in rig.torques_since(start + 0.01)} == {(0.0, 0.0, 0.0)}
    assert rig.watchdog.n_fed == n_fed
    rig.driver.clear_fault("Ada")
    rig.run(0.1)
    assert rig.watchdog.n_fed == n_fed + 50


def test_a_watchdog_that_trips_is_a_fault_until_a_person_clears_it(rig):
    start = rig.pull().clock.time
    rig.watchdog.is_there = False
    rig.aim()
    check_reaction(rig, start, FaultKind.WATCHDOG)
    rig.driver.clear_fault("Ada")
    assert rig.watchdog.n_cleared == 1
    assert rig.driver.mode is Mode.SAFE
    rig.driver.arm()


def test_a_watchdog_that_has_tripped_before_is_cleared_without_a_fault(rig):
    rig.run(0.1)
    rig.watchdog.is_there = False
    with pytest.raises(DriveError, match="the name of a person"):
        rig.driver.clear_fault("")
    rig.driver.clear_fault("Ada")
    assert rig.watchdog.is_there
    with pytest.raises(DriveError, match="cannot clear a fault: the driver is in safe"):
        rig.driver.clear_fault("Ada")


def test_a_watchdog_whose_line_is_gone_is_a_fault(rig):
    start = rig.pull().clock.time
    rig.watchdog.is_gone = True
    rig.aim()
    check_reaction(rig, start, FaultKind.WATCHDOG)


def test_a_fault_is_cleared_after_the_ramp_and_leads_to_safe(rig):
    rig.pull()
    rig.driver.stop()
    with pytest.raises(DriveError, match="the torque is not off yet"):
        rig.driver.clear_fault("Ada")
    rig.run(0.05)
    rig.driver.clear_fault("Ada")
    assert rig.driver.mode is Mode.SAFE
    rig.driver.arm()


def test_feedback_that_is_no_number_is_a_fault(rig):
    start = rig.pull().clock.time
    rig.motors.speed[2] = math.nan
    rig.motors._advance = lambda i: None
    rig.aim()
    check_reaction(rig, start, FaultKind.IMPLAUSIBLE_FEEDBACK)


def test_a_fault_while_letting_go_ramps_faster(rig):
    rig.pull()
    rig.driver.disarm()
    rig.run(0.02)
    start = rig.clock.time
    rig.motors.is_silent = True
    check_reaction(rig, start, FaultKind.STALE_FEEDBACK)


# Homing.


class Failing(HomingRoutine):
    def start(self, motors) -> None: ...

    def step(self, motors, now, dt) -> HomingStep:
        return HomingStep((0.05,) * len(motors))


def test_homing_probes_each_motor_first(rig):
    rig.run(0.05)
    rig.driver.home()
    start = rig.clock.time
    rig.run(0.5)
    pulses = [sum(torques[i] > 0.0 for _, torques in rig.torques_since(start)) * DT for i in range(3)]
    assert pulses == pytest.approx([0.04] * 3, abs=2 * DT)


def test_exchanged_motors_are_found_before_any_cable_is_loaded(rig):
    show = rig.motors._show
    rig.motors._show = lambda i: dataclasses.replace(show(i), torque=rig.motors.torque[(1, 0, 2)[i]])
    rig.run(0.05)
    rig.driver.home()
    rig.run(0.5)
    assert rig.kinds[0] is FaultKind.IMPLAUSIBLE_FEEDBACK
    assert "was answered by motor 2" in rig.driver.faults[0].text
    assert not rig.driver.is_homed


def test_faults_and_a_stop_end_homing():
    rig = build(homing=Failing())
    rig.run(0.05)
    rig.driver.home()
    rig.run(0.6)
    assert rig.driver.mode is Mode.HOMING
    rig.driver.stop()
    rig.run(0.1)
    assert rig.driver.mode is Mode.FAULT
    assert not rig.driver.is_homed
    assert rig.motors.torque == [0.0] * 3


def test_the_winders_home_by_themselves():
    rig = build()
    driver = TrunkDriver(
        design=DESIGN, motors=rig.motors, winders=[build_winder(DESIGN, SHEET, DRUM, DT) for _ in range(3)],
        watchdog=rig.watchdog, clock=rig.clock,
    )  # fmt: skip
    rig.driver = driver
    rig.motors.angle = [-1.0, -0.5, -0.2]
    rig.run(0.05)
    driver.home()
    rig.run(8.0)
    assert driver.mode is Mode.SAFE, driver.faults
    assert driver.is_homed


# Arm and servo.


def test_a_new_position_is_sent_once_and_the_gripper_when_it_changes():
    rig = build(with_sides=True).pull()
    rig.aim(arm_position=[0.1] * 7, gripper=1.0, valid_for=0.1)
    rig.run(0.05)
    assert [one.tolist() for one in rig.arm.sent] == [[0.1] * 7]
    assert rig.servo.pulses == [1500.0, 2000.0]
    rig.aim(gripper=-0.5)
    rig.run(DT)
    assert rig.servo.pulses[-1] == 1250.0
    assert len(rig.arm.sent) == 1


@pytest.mark.parametrize(
    ("spoil", "text"),
    [(lambda arm: setattr(arm, "error", "reflex"), "reports reflex"), (lambda arm: setattr(arm, "age", 0.051), "old"),
     (lambda arm: setattr(arm, "is_gone", True), "gone"), (lambda arm: setattr(arm, "refusal", "a jump"), "a jump"),
     (lambda arm: setattr(arm, "position", np.full(7, np.nan)), "not finite")],
)  # fmt: skip
def test_an_arm_that_fails_stops_all_and_is_held(spoil, text):
    rig = build(with_sides=True).pull()
    start = rig.clock.time
    spoil(rig.arm)
    rig.aim(arm_position=[0.1] * 7)
    check_reaction(rig, start, FaultKind.ARM)
    assert text in rig.driver.faults[0].text
    assert rig.arm.n_held == 1


def test_on_a_fault_the_arm_holds_at_once_and_gets_no_position():
    rig = build(with_sides=True).pull()
    rig.aim(arm_position=[0.1] * 7, gripper=1.0)
    rig.driver.stop()
    assert rig.arm.n_held == 1
    rig.run(0.2)
    assert rig.arm.sent == []
    assert rig.servo.pulses == [1500.0], "no pulse on a fault"
    assert rig.servo.n_released == 1, "limp after the ramp"


def test_the_gripper_has_the_pulses_of_its_calibration():
    calibration = ServoCalibration(least_us=900, most_us=2100, open_us=1900, slack_us=1300, closed_us=1000)
    rig = build(with_sides=True, options=DriverOptions(gripper=calibration)).pull()
    for gripper in (-1.0, -0.5, 0.0, 1.0):
        rig.aim(gripper=gripper, valid_for=0.1)
        rig.run(DT)
    assert rig.servo.pulses == [1300.0, 1900.0, 1600.0, 1300.0, 1000.0]


def test_a_servo_that_fails_is_a_fault():
    rig = build(with_sides=True).pull()
    start = rig.clock.time
    rig.servo.is_gone = True
    rig.aim(gripper=1.0)
    check_reaction(rig, start, FaultKind.SERVO)


def test_an_arm_in_error_keeps_from_arming():
    rig = build(with_sides=True)
    rig.arm.error = "reflex"
    rig.run(0.05)
    assert rig.driver.snapshot().warnings == ("the arm's controller reports reflex",)
    rig.driver.home()
    rig.run(0.5)
    assert rig.kinds[0] is FaultKind.ARM


# The loop.


def test_close_lets_go_and_releases_everything_once():
    rig = build(with_sides=True).pull()
    with rig.driver:
        pass
    assert rig.motors.torque == [0.0] * 3
    assert rig.motors.is_closed
    assert rig.arm.is_closed
    assert rig.watchdog.n_ended == 1
    rig.driver.close()
    assert rig.watchdog.n_ended == 1
    with pytest.raises(DriveError, match="the driver is closed"):
        rig.driver.tick()


def test_close_releases_motors_and_arm_where_the_loop_fails():
    """The watchdog is not told of an end in order: it takes the torque off."""
    rig = build(with_sides=True).ready()
    rig.run(0.1, lambda one: one.aim(gripper=1.0))
    rig.motors.read = fail
    with pytest.raises(ZeroDivisionError):
        rig.driver.close()
    assert rig.motors.is_closed
    assert rig.arm.is_closed
    assert rig.servo.n_released == 1
    assert rig.watchdog.n_ended == 0
    rig.driver.close()


def test_close_releases_motors_and_arm_where_the_servo_fails():
    rig = build(with_sides=True).ready()
    rig.run(0.1, lambda one: one.aim(gripper=1.0))
    rig.servo.release = fail
    with pytest.raises(ZeroDivisionError):
        rig.driver.close()
    assert rig.motors.is_closed
    assert rig.arm.is_closed


def fail() -> None:
    raise ZeroDivisionError


def test_a_driver_whose_motors_may_not_obey_does_not_end_the_watch(rig):
    rig.pull()
    rig.motors.is_silent = True
    rig.run(0.3)
    assert rig.driver.mode is Mode.FAULT
    rig.driver.close()
    assert rig.watchdog.n_ended == 0


def test_two_ticks_at_one_moment_are_one(rig):
    rig.pull()
    count = len(rig.motors.sent)
    rig.driver.tick()
    assert len(rig.motors.sent) == count


def test_lateness_is_told_and_missed_periods_are_not_made_up_for(rig):
    rig.run(0.1)
    for _ in range(50):
        rig.driver.wait()
        rig.clock.time += 0.005
        rig.driver.tick()
    shown = rig.driver.snapshot().lateness
    assert shown.n_period == 100
    assert shown.p50 == pytest.approx(0.0025, abs=0.0026)
    assert shown.p99 == pytest.approx(0.005)
    assert shown.p999 == pytest.approx(0.005)


def test_a_host_that_hung_stops_with_a_stale_command(rig):
    rig.pull()
    rig.clock.time += 0.3
    rig.driver.tick()
    assert rig.kinds == [FaultKind.STALE_COMMAND]
