"""Every fault does what its name says, at its time, and the same again with the same seed."""

from __future__ import annotations

import math
import random
from collections import Counter
from collections.abc import Callable
from itertools import pairwise

import pytest

from spiraltrunk.design.presets import PAPER
from spiraltrunk.errors import DesignError, DriveError, UnknownName
from spiraltrunk.hardware.bus.frame_bus import Frame
from spiraltrunk.hardware.motors.gm6020 import TORQUE_PER_RAW, decode_feedback
from spiraltrunk.hardware.safety.watchdog import CLEAR_FLAG, HEARTBEAT_FORMAT, HEARTBEAT_ID
from spiraltrunk.hardware.twin.faults import FAULTS, FaultInjector, build_fault, describe_fault
from spiraltrunk.hardware.twin.trunk.anchor import Anchor
from spiraltrunk.hardware.twin.trunk.spring_trunk import SpringTrunk

from .conftest import Setup, feedback_of

NAMES = {
    "frame_loss", "delay", "reorder", "duplicate", "bus_off", "frozen_feedback", "corrupt", "id_swap", "encoder_wrap",
    "power_cycle", "over_temperature", "stall", "cable_break", "cable_slip", "tangled_drum",
    "cell_silent", "cell_unplugged", "cell_stuck", "cell_wire_off",
}  # fmt: skip
ENDS = pytest.mark.parametrize("at_motors", [False, True], ids=["driver's end", "motors' end"])


def loose() -> Anchor:
    """Cables that never become taut."""
    return Anchor(10.0, 10.0, 10.0)


def spin(setup: Setup) -> None:
    """Motors that turn, so that every feedback differs from the last."""
    setup.command(0.5, 0.5, 0.5)
    setup.run(0.05)


def test_the_catalogue_is_complete_and_told() -> None:
    assert set(FAULTS) == NAMES
    for name in FAULTS:
        assert describe_fault(name).endswith(".")
        assert build_fault(name).name == name


@pytest.mark.parametrize(
    ("name", "settings", "words"),
    [
        ("frame_loss", {"probability": 1.1}, "probability"),
        ("frame_loss", {"probability": math.nan}, "probability"),
        ("frame_loss", {"chance": 0.1}, "probability, direction"),
        ("delay", {"direction": "sideways"}, "commands, feedback or both"),
        ("delay", {"duration": -1.0}, "duration"),
        ("id_swap", {"cable": 1, "other": 1}, "another cable"),
        ("stall", {"cable": -1}, "cable"),
        ("frozen_feedback", {"motor_id": 8}, "motor_id"),
        ("over_temperature", {"rate": 0.0}, "rate"),
    ],
)
def test_settings_that_make_no_sense_are_refused(name: str, settings: dict[str, object], words: str) -> None:
    with pytest.raises(DesignError, match=words):
        build_fault(name, settings)


def test_unknown_names_are_told_the_known_ones() -> None:
    with pytest.raises(UnknownName, match="cable_break"):
        build_fault("gremlin")
    with pytest.raises(UnknownName, match="cable_break"):
        describe_fault("gremlin")


@pytest.mark.parametrize("name", sorted(NAMES - {"encoder_wrap"}))
@ENDS
def test_same_seed_same_run(build: Callable[..., Setup], name: str, at_motors: bool) -> None:
    def play(seed: int) -> list[Frame]:
        setup = build(at_motors=at_motors, seed=seed)
        setup.injector.inject(build_fault(name), at=0.05, until=0.15)
        frames = []
        for k in range(100):
            try:
                setup.command(0.3, 0.2 * math.sin(k), 0.1)
                frames += setup.run(2e-3)
            except DriveError:
                setup.clock.sleep_until(setup.clock.now() + 2e-3)
        return frames

    assert play(1) == play(1)
    if hasattr(build_fault(name), "probability"):
        assert play(1) != play(2)


def test_without_faults_the_wrapped_bus_is_the_bus(build: Callable[..., Setup]) -> None:
    setup = build()
    setup.bus.send(Frame(0x1FE, bytes(8)))
    setup.bus.flush()
    assert len(setup.run(0.1)) == 300
    setup.injector.inject(build_fault("frame_loss", {"probability": 0.0}))
    assert len(setup.run(0.1)) == 300


@ENDS
def test_frame_loss_loses_its_part(build: Callable[..., Setup], at_motors: bool) -> None:
    setup = build(at_motors=at_motors)
    setup.injector.inject(build_fault("frame_loss", {"probability": 0.2}))
    kept = len(setup.run(2.0)) / 6000
    assert kept == pytest.approx(0.8, abs=4 * math.sqrt(0.2 * 0.8 / 6000))


@ENDS
def test_frame_loss_can_concern_commands_alone(build: Callable[..., Setup], at_motors: bool) -> None:
    setup = build(at_motors=at_motors)
    setup.injector.inject(build_fault("frame_loss", {"probability": 1.0, "direction": "commands"}))
    setup.command(0.5, 0.5, 0.5)
    assert len(setup.run(0.1)) == 300
    assert [motor.current for motor in setup.motors.motors] == [0.0] * 3
    setup.injector.clear()
    setup.injector.inject(build_fault("frame_loss", {"probability": 1.0, "direction": "feedback"}))
    setup.command(0.5, 0.5, 0.5)
    assert setup.run(0.1) == []
    assert all(motor.current > 0.1 for motor in setup.motors.motors)


@ENDS
def test_delay_brings_every_frame_late_and_in_order(build: Callable[..., Setup], at_motors: bool) -> None:
    """What arrives is what the motor was 20 ms ago, and its time is that of its arrival."""
    setup = build(loose(), at_motors=at_motors)
    setup.command(0.5, 0.5, 0.5)
    prompt = build(loose())
    prompt.command(0.5, 0.5, 0.5)
    setup.injector.inject(build_fault("delay", {"duration": 0.02, "direction": "feedback"}))
    late = [frame for frame in setup.run(0.3) if frame.id == 0x205]
    right = [frame for frame in prompt.run(0.3) if frame.id == 0x205]
    assert [frame.data for frame in late] == [frame.data for frame in right[: len(late)]]
    assert len(late) == 280
    for one, other in zip(late, right, strict=False):
        assert one.time - other.time == pytest.approx(0.02, abs=1.1e-3)


def test_delay_holds_commands_back(build: Callable[..., Setup]) -> None:
    setup = build(at_motors=True)
    setup.injector.inject(build_fault("delay", {"duration": 0.02, "direction": "commands"}))
    setup.run(1e-3)
    setup.command(0.5, 0.5, 0.5)
    setup.run(0.018)
    assert setup.motors.motors[0].current == 0.0
    setup.run(0.01)
    assert setup.motors.motors[0].current > 0.1


@ENDS
def test_reorder_lets_frames_overtake_and_loses_none(build: Callable[..., Setup], at_motors: bool) -> None:
    setup = build(loose(), at_motors=at_motors)
    setup.command(0.5, 0.5, 0.5)
    setup.injector.inject(build_fault("reorder", {"probability": 0.2, "direction": "feedback"}), until=0.2)
    temperatures = setup.motors.motors[0]
    counts = []
    for _ in range(250):
        counts += [feedback.speed_rpm for feedback in feedback_of(setup.run(1e-3))]
    assert temperatures.speed > 0
    backwards = sum(later < earlier for earlier, later in pairwise(counts))
    assert backwards > 5
    assert 245 <= len(counts) <= 250  # The frames held when the fault ends are lost.


@ENDS
def test_duplicate_brings_frames_twice(build: Callable[..., Setup], at_motors: bool) -> None:
    setup = build(loose(), at_motors=at_motors)
    setup.injector.inject(build_fault("duplicate", {"probability": 0.2, "direction": "feedback"}))
    setup.command(0.5, 0.5, 0.5)
    frames = setup.run(1.0)
    assert len(frames) / 3000 == pytest.approx(1.2, abs=4 * math.sqrt(0.2 * 0.8 / 3000))
    assert max(Counter((frame.id, frame.time) for frame in frames).values()) == 2


def test_bus_off_raises_at_its_end_and_leaves_nothing_stale(build: Callable[..., Setup]) -> None:
    setup = build()
    setup.injector.inject(build_fault("bus_off"), at=0.1, until=0.2)
    assert len(setup.run(0.099)) == 297
    setup.clock.sleep_until(0.15)
    with pytest.raises(DriveError, match="bus is off"):
        setup.bus.receive()
    with pytest.raises(DriveError, match="bus is off"):
        setup.command(0.5, 0.5, 0.5)
    setup.clock.sleep_until(0.2)
    frames = setup.run(0.1)
    assert {round(frame.time, 6) for frame in frames} == {round(0.2 + 1e-3 * k, 6) for k in range(101)}
    assert [motor.current for motor in setup.motors.motors] == [0.0] * 3


def test_bus_off_at_the_motors_end_is_silence(build: Callable[..., Setup]) -> None:
    setup = build(at_motors=True)
    setup.injector.inject(build_fault("bus_off"), at=0.1, until=0.2)
    assert len(setup.run(0.099)) == 297
    setup.run(1e-3)
    setup.command(0.5, 0.5, 0.5)
    assert setup.run(0.098) == []
    assert setup.motors.motors[0].current == 0.0
    assert len(setup.run(0.1)) >= 297
    assert setup.motors.motors[0].current == 0.0


@ENDS
def test_frozen_feedback_repeats_one_motor_at_the_usual_rate(build: Callable[..., Setup], at_motors: bool) -> None:
    setup = build(loose(), at_motors=at_motors)
    spin(setup)
    setup.injector.inject(build_fault("frozen_feedback", {"motor_id": 2}))
    frames = setup.run(0.1)
    contents = {i: {frame.data for frame in frames if frame.id == 0x204 + i} for i in (1, 2, 3)}
    assert len(contents[2]) == 1
    assert len(contents[1]) > 50
    assert sum(frame.id == 0x206 for frame in frames) == 100


@ENDS
def test_corrupt_changes_bit_length_or_id_of_its_part(build: Callable[..., Setup], at_motors: bool) -> None:
    setup = build(at_motors=at_motors)
    right = build().run(2.0)
    setup.injector.inject(build_fault("corrupt", {"probability": 0.3}))
    wrong = setup.run(2.0)
    assert len(right) == len(wrong)
    kinds: Counter[str] = Counter()
    for one, other in zip(right, wrong, strict=True):
        if one.id != other.id:
            kinds["id"] += 1
        elif len(one.data) != len(other.data):
            kinds["length"] += 1
        elif one.data != other.data:
            kinds["bit"] += 1
            assert (int.from_bytes(one.data, "big") ^ int.from_bytes(other.data, "big")).bit_count() == 1
    assert sum(kinds.values()) / 6000 == pytest.approx(0.3, abs=0.03)
    assert min(kinds.values()) > 400
    assert all(0 <= frame.id <= 0x7FF and len(frame.data) <= 8 for frame in wrong)


def test_id_swap_exchanges_commands_and_feedback(build: Callable[..., Setup]) -> None:
    setup = build(loose())
    setup.injector.inject(build_fault("id_swap", {"cable": 0, "other": 2}))
    setup.command(0.5, 0.0, 0.0)
    frames = setup.run(0.1)
    assert setup.motors.motors[0].angle == 0.0
    assert setup.motors.motors[2].angle > 1.0
    assert feedback_of(frames, 1)[-1].speed_rpm > 10
    assert feedback_of(frames, 3)[-1].speed_rpm == 0
    setup.injector.clear("id_swap")
    setup.command(0.5, 0.0, 0.0)
    setup.run(0.1)
    assert setup.motors.motors[0].angle > 1.0


@pytest.mark.parametrize("is_reversed", [False, True])
def test_encoder_wrap_wraps_at_the_first_movement(build: Callable[..., Setup], is_reversed: bool) -> None:
    setup = build(loose(), is_reversed=is_reversed)
    setup.injector.inject(build_fault("encoder_wrap", {"cable": 1, "margin": 1}))
    first = feedback_of(setup.run(1e-3), 2)[0].angle
    assert first == (1 if is_reversed else 8190)
    setup.command(0.0, -0.3 if is_reversed else 0.3, 0.0)
    counts = [feedback.angle for feedback in feedback_of(setup.run(0.05), 2)]
    jumps = [later - earlier for earlier, later in pairwise([first, *counts]) if abs(later - earlier) > 4096]
    assert len(jumps) == 1
    assert setup.motors.motors[1].wound > 0.0


def test_encoder_wrap_is_for_the_start_alone(build: Callable[..., Setup]) -> None:
    setup = build()
    setup.run(0.01)
    with pytest.raises(DriveError, match="before"):
        setup.injector.inject(build_fault("encoder_wrap"))
    assert setup.injector.active == ()


def test_power_cycle_is_silent_limp_and_forgets_its_command(build: Callable[..., Setup]) -> None:
    setup = build()
    for motor in setup.motors.motors:
        motor.is_blocked = True
    setup.command(0.5, 0.5, 0.5)
    setup.run(0.1)
    setup.injector.inject(build_fault("power_cycle", {"cable": 1}))
    quiet = setup.run(0.299)
    assert [sum(frame.id == 0x204 + i for frame in quiet) for i in (1, 2, 3)] == [299, 0, 299]
    assert setup.motors.motors[1].current == pytest.approx(0.0, abs=1e-9)
    after = setup.run(0.1)
    assert sum(frame.id == 0x206 for frame in after) == 100
    assert setup.motors.motors[1].current == pytest.approx(0.0, abs=1e-9)
    assert setup.motors.motors[0].torque == pytest.approx(0.5, abs=TORQUE_PER_RAW)
    assert setup.injector.active == ()
    setup.command(0.5, 0.5, 0.5)
    setup.run(0.1)
    assert setup.motors.motors[1].torque == pytest.approx(0.5, abs=TORQUE_PER_RAW)


def test_power_cycle_leaves_the_angle_within_a_turn(build: Callable[..., Setup]) -> None:
    """The rotor coasts on while nobody listens; the encoder tells where it is, and not how often it went round."""
    setup = build(loose(), friction=1e-4)
    setup.command(1.0, 0.0, 0.0)
    before = feedback_of(setup.run(0.2))[-1].angle
    setup.injector.inject(build_fault("power_cycle", {"cable": 0}))
    start = setup.motors.motors[0].angle
    after = feedback_of(setup.run(0.35))[0].angle
    turned = setup.motors.motors[0].angle - start
    assert turned > math.tau
    assert before != after


def test_over_temperature_heats_to_its_temperature_and_holds_it(build: Callable[..., Setup]) -> None:
    setup = build()
    setup.injector.inject(build_fault("over_temperature", {"cable": 2, "temperature": 95.0, "rate": 20.0}))
    setup.run(1.0)
    motor = setup.motors.motors[2]
    assert motor.temperature == pytest.approx(45.0, abs=0.5)
    frames = setup.run(9.0)
    assert motor.temperature == pytest.approx(95.0, abs=0.1)
    assert feedback_of(frames, 3)[-1].temperature == 95
    setup.injector.clear("over_temperature")
    setup.run(10.0)
    assert motor.temperature < 94.0
    assert setup.motors.motors[0].temperature == 25.0


def test_stall_holds_the_rotor_while_the_current_flows(build: Callable[..., Setup]) -> None:
    setup = build(loose())
    spin(setup)
    setup.injector.inject(build_fault("stall", {"cable": 0}))
    angle = setup.motors.motors[0].angle
    frames = setup.run(0.1)
    assert setup.motors.motors[0].angle == angle
    last = feedback_of(frames)[-1]
    assert last.speed_rpm == 0
    assert last.current * TORQUE_PER_RAW == pytest.approx(0.5, abs=2 * TORQUE_PER_RAW)
    setup.injector.clear()
    setup.run(0.1)
    assert setup.motors.motors[0].angle > angle + 0.1


def tighten(setup: Setup) -> None:
    """Ten newtons in every cable."""
    p = setup.motors.motors[0].parameters
    torque = 10.0 * p.drum_radius + p.friction
    setup.command(torque, torque, torque)
    setup.run(0.3)
    assert all(tension > 8.0 for tension in setup.motors.tensions)


def test_cable_break_ends_the_tension_and_lets_the_drum_run(build: Callable[..., Setup]) -> None:
    setup = build()
    tighten(setup)
    setup.injector.inject(build_fault("cable_break", {"cable": 1}))
    wound = setup.motors.motors[1].wound
    setup.run(0.2)
    assert setup.motors.tensions[1] == 0.0
    assert setup.motors.motors[1].wound > wound + 0.01
    assert setup.motors.tensions[0] > 8.0


def test_cable_slip_gives_cable_that_the_angle_does_not_tell(build: Callable[..., Setup]) -> None:
    setup = build()
    tighten(setup)
    motor = setup.motors.motors[0]
    angle, wound, tension = motor.angle, motor.wound, setup.motors.tensions[0]
    setup.injector.inject(build_fault("cable_slip", {"cable": 0, "length": 3e-3}))
    assert motor.angle == angle
    assert motor.wound == pytest.approx(wound - 3e-3)
    setup.run(2e-3)
    assert setup.motors.tensions[0] == 0.0
    setup.run(0.5)
    assert setup.motors.tensions[0] == pytest.approx(tension, abs=8.0)
    assert motor.angle - angle == pytest.approx(3e-3 / 0.01, abs=0.06)


def test_a_tangled_drum_winds_the_wrong_way_or_another_length(build: Callable[..., Setup]) -> None:
    for factor in (-1.0, 1.3):
        setup = build(loose())
        spin(setup)
        motor = setup.motors.motors[0]
        angle, wound = motor.angle, motor.wound
        setup.injector.inject(build_fault("tangled_drum", {"cable": 0, "factor": factor}))
        setup.run(0.05)
        assert motor.wound - wound == pytest.approx(factor * 0.01 * (motor.angle - angle))


def test_a_tangled_drum_pulls_when_it_should_pay_out(build: Callable[..., Setup]) -> None:
    setup = build()
    setup.injector.inject(build_fault("tangled_drum"))
    setup.command(-0.3, 0.0, 0.0)
    setup.run(0.5)
    assert setup.motors.tensions[0] > 8.0


def test_faults_begin_and_end_at_their_times(build: Callable[..., Setup]) -> None:
    events: list[tuple[float, str, bool]] = []
    setup = build()
    injector = FaultInjector(setup.motors, on_change=lambda *event: events.append(event))
    injector.inject(build_fault("stall"), at=0.01, until=0.02)
    injector.inject(build_fault("power_cycle", {"duration": 0.005}), at=0.01)
    for _ in range(30):
        injector.advance(1e-3)
    assert [(round(time, 6), name, begun) for time, name, begun in events] == [
        (0.01, "stall", True),
        (0.01, "power_cycle", True),
        (0.015, "power_cycle", False),
        (0.02, "stall", False),
    ]


def test_a_fault_that_has_not_begun_can_be_cleared(build: Callable[..., Setup]) -> None:
    setup = build()
    setup.injector.inject(build_fault("stall"), at=0.05)
    setup.injector.clear("stall")
    setup.run(0.1)
    assert not setup.motors.motors[0].is_blocked
    with pytest.raises(UnknownName, match="stall"):
        setup.injector.clear("stall")


def test_what_cannot_be_injected_is_refused(build: Callable[..., Setup]) -> None:
    setup = build()
    with pytest.raises(DriveError, match="0 to 2"):
        setup.injector.inject(build_fault("stall", {"cable": 3}))
    with pytest.raises(DriveError, match="bus for faults"):
        FaultInjector(setup.motors).inject(build_fault("delay"), at=1.0)
    with pytest.raises(DesignError, match="after 1 s"):
        setup.injector.inject(build_fault("stall"), at=1.0, until=1.0)
    assert setup.injector.active == ()


def test_faults_add_up(build: Callable[..., Setup]) -> None:
    """Two faults of half the frames leave a quarter of them, each a sound frame."""
    setup = build()
    for _ in range(2):
        setup.injector.inject(build_fault("frame_loss", {"probability": 0.5, "direction": "feedback"}))
    frames = setup.run(2.0)
    assert len(frames) / 6000 == pytest.approx(0.25, abs=0.03)
    assert all(decode_feedback(frame.data) is not None for frame in frames)


@pytest.mark.slow
def test_whatever_fails_the_twin_goes_on(build: Callable[..., Setup]) -> None:
    """Half a minute of random faults: every state stays finite, no cable pushes, every feedback is sound."""
    chance = random.Random(5)
    setup = build(SpringTrunk(PAPER, theta_0=0.3), is_watched=True, feedback_period=2e-3)
    names = sorted(NAMES - {"encoder_wrap", "corrupt"})
    for counter in range(6_000):
        if counter % 200 == 0:
            name = chance.choice(names)
            settings = {"cable": chance.choice((0, 2))} if hasattr(build_fault(name), "cable") else {}
            now = setup.clock.now()
            setup.injector.inject(build_fault(name, settings), at=now, until=now + chance.uniform(0.1, 2.0))
        try:
            setup.bus.send(Frame(HEARTBEAT_ID, HEARTBEAT_FORMAT.pack(counter & 0xFFFF, CLEAR_FLAG)))
            setup.command(*(chance.uniform(-0.5, 0.5) for _ in range(3)))
            frames = setup.bus.receive()
        except DriveError:
            frames = []
        assert all(decode_feedback(frame.data) is not None for frame in frames if frame.id < 0x300)
        setup.clock.sleep_until((counter + 1) * 5e-3)
        assert all(0.0 <= tension < 1e4 for tension in setup.motors.tensions)
        assert all(math.isfinite(motor.wound + motor.temperature) for motor in setup.motors.motors)
