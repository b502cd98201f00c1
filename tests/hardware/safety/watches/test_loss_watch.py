"""Loss of feedback: noticed in time where frames are lost, and not at all where they come in bunches."""

from __future__ import annotations

import random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from spiraltrunk.hardware.motors.motor_port import MotorState
from spiraltrunk.hardware.safety.fault import FaultKind
from spiraltrunk.hardware.safety.limits import SafetyLimits
from spiraltrunk.hardware.safety.watches.loss_watch import LossState, watch_loss

LIMITS = SafetyLimits()
DT = 0.002
FRAME = 0.001


def build(time: float = 0.0, *, n_frame: int | None = None) -> MotorState:
    return MotorState(time=time, angle=0.0, speed=0.0, torque=0.0, temperature=30.0, n_frame=n_frame)


def run_loss(
    losses: list[list[bool]], *, frames: int = 0, limits: SafetyLimits = LIMITS
) -> tuple[LossState, list[tuple[int, tuple]]]:
    """Periods in each of which each motor's feedback is lost or not; with ``frames``, that many of each are due."""
    n_motor = len(losses[0])
    state, times, counts, found = LossState(), [0.0] * n_motor, [0] * n_motor, []
    for number, lost in enumerate([[False] * n_motor, *losses]):
        for i, is_lost in enumerate(lost):
            if not is_lost:
                times[i], counts[i] = number * DT, counts[i] + frames
        motors = tuple(
            build(time=time, n_frame=count if frames else None) for time, count in zip(times, counts, strict=True)
        )
        state, findings = watch_loss(state, motors, DT, DT / frames if frames else None, limits)
        if findings:
            found.append((number, findings))
    return state, found


def test_twenty_missed_periods_in_a_row_are_a_fault_of_that_motor():
    state, found = run_loss([[False, True, False]] * 20)
    number, findings = found[0]
    assert number <= 20
    assert state.heard[1].missed == 20
    assert (1, FaultKind.STALE_FEEDBACK) in [(motor, one.kind) for motor, one in findings]
    assert state.heard[0].missed == 0


@pytest.mark.parametrize(("period", "has_count"), [(None, True), (FRAME, False), (None, False)])
def test_without_a_period_or_a_count_one_frame_of_each_is_due_in_a_period_of_control(period, has_count):
    """Three frames that came at once are no more than one; of two motors one is lost in each tenth period."""
    state, times, counts = LossState(), [0.0, 0.0], [0, 0]
    for number in range(1, 5000):
        for i in range(2):
            if i == 0 or number % 10:
                times[i], counts[i] = number * DT, counts[i] + 3
        motors = tuple(build(times[i], n_frame=counts[i] if has_count else None) for i in range(2))
        state, found = watch_loss(state, motors, DT, period, LIMITS)
        assert not found
    assert state.loss == pytest.approx(0.05, abs=0.005)


def test_missed_periods_that_are_not_in_a_row_count_anew():
    losses = ([[True]] * 8 + [[False]] * 60) * 5
    state, found = run_loss(losses)
    assert not found
    assert state.heard[0].missed == 0
    assert state.evidence == 0.0


def lose_frames(part: float, seed: int, periods: int, frames: int = 2) -> tuple[float, int | None]:
    """Loss of single frames of three motors at ``frames`` a period: mean, and the period in which it is a fault."""
    random.seed(seed)
    state, counts, times = LossState(), [0] * 3, [0.0] * 3
    for number in range(periods):
        for i in range(3):
            came = sum(random.random() >= part for _ in range(frames))
            if came:
                counts[i] += came
                times[i] = number * DT
        motors = tuple(build(time=time, n_frame=count) for time, count in zip(times, counts, strict=True))
        state, findings = watch_loss(state, motors, DT, DT / frames, LIMITS)
        if findings:
            return state.loss, number
    return state.loss, None


@pytest.mark.parametrize("part", [0.0, 0.01, 0.05])
def test_up_to_5_percent_lost_are_no_fault_and_are_shown(part):
    loss, number = lose_frames(part, seed=1, periods=5000)
    assert number is None
    assert loss == pytest.approx(part, abs=0.02)


def test_20_percent_lost_are_noticed_within_60_ms_on_the_average():
    """So that the ramp of 40 ms ends within 100 ms."""
    delays = [DT * lose_frames(0.2, seed, 1000)[1] for seed in range(40)]
    print(f"mean {1e3 * sum(delays) / len(delays):.0f} ms, longest {1e3 * max(delays):.0f} ms")
    assert sum(delays) / len(delays) < 0.060


def test_20_percent_lost_are_noticed_without_a_count_of_frames():
    random.seed(3)
    _, found = run_loss([[random.random() < 0.2 for _ in range(3)] for _ in range(500)])
    number, findings = found[0]
    assert number * DT < 0.2
    assert findings[0][0] is None
    assert findings[0][1].kind is FaultKind.STALE_FEEDBACK


def test_frames_that_come_a_period_late_are_not_lost():
    """One frame, then three: jitter of the adapter, no loss."""
    state, count = LossState(), 0
    for number in range(2000):
        count += 1 if number % 2 else 3
        state, findings = watch_loss(state, (build(time=number * DT, n_frame=count),), DT, DT / 2, LIMITS)
        assert not findings
    assert abs(state.loss) < 0.01


def test_the_shown_loss_is_a_mean_over_its_memory():
    state, _ = run_loss([[False]] * 10)
    assert state.loss == 0.0
    state, _ = run_loss([[True]] * 19)
    assert state.loss == pytest.approx(1.0 - (1.0 - DT / LIMITS.loss_memory) ** 19)
    state, _ = run_loss([[True]], limits=SafetyLimits(loss_memory=0.5))
    assert state.loss == pytest.approx(DT / 0.5)


def test_an_outage_counts_once_and_not_as_a_loss():
    """All motors silent for 19 periods, now and then, are under the limit for periods in a row."""
    assert run_loss(([[True] * 3] * 19 + [[False] * 3] * 100) * 5)[1] == []
    assert run_loss(([[True] * 3] * 19 + [[False] * 3] * 100) * 5, frames=2)[1] == []
    number, findings = run_loss([[True] * 3] * 20)[1][0]
    assert number == 20
    assert [motor for motor, _ in findings] == [0, 1, 2]


# Bunches.


def hear(reads: list[tuple[float, list[int]]]) -> tuple[LossState, list]:
    """Reads at these times, each with the frames of each motor that came since the one before."""
    state, now, counts, times, found = LossState(), 0.0, [0] * len(reads[0][1]), [0.0] * len(reads[0][1]), []
    for time, came in [(0.0, [1] * len(counts)), *reads]:
        dt, now = time - now, time
        for i, one in enumerate(came):
            counts[i], times[i] = counts[i] + one, time if one else times[i]
        motors = tuple(build(at, n_frame=count) for at, count in zip(times, counts, strict=True))
        state, findings = watch_loss(state, motors, dt, FRAME, LIMITS)
        found += findings
    return state, found


@st.composite
def draw_bunches(draw) -> list[tuple[float, list[int]]]:
    """A complete 1 kHz stream of three motors, read by a host that is late by up to 15 ms at any time.

    What has piled up comes at once or in portions; the next pause begins after it has come.
    """
    reads, now, read = [], 0.0, 0
    for pause, portions, periods in draw(
        st.lists(st.tuples(st.floats(0.0005, 0.015), st.integers(1, 4), st.integers(0, 4)), min_size=1, max_size=60)
    ):
        now += pause
        for left in range(portions, 0, -1):
            sent = round(now // FRAME)
            came = (sent - read + left - 1) // left
            reads.append((now, [came] * 3))
            read, now = read + came, now + 0.0002
        for _ in range(periods):
            now += DT
            came, read = round(now // FRAME) - read, round(now // FRAME)
            reads.append((now, [came] * 3))
    return reads


@given(draw_bunches())
def test_a_complete_stream_in_any_bunches_is_no_loss(reads):
    state, found = hear(reads)
    assert found == []
    assert state.loss < 0.8 * LIMITS.loss_warned, "no warning, either"


@given(draw_bunches(), st.integers(0, 1000))
def test_a_stream_in_bunches_with_1_percent_lost_goes_on(reads, seed):
    chance = random.Random(seed)
    lossy = [(time, [sum(chance.random() >= 0.01 for _ in range(one)) for one in came]) for time, came in reads]
    assert hear(lossy)[1] == []


def test_bunches_that_lose_20_percent_are_noticed():
    """A host that reads every 10 ms: each bunch lacks frames of each motor."""
    delays = []
    for seed in range(20):
        random.seed(seed)
        reads = [(0.01 * k, [sum(random.random() >= 0.2 for _ in range(10)) for _ in range(3)]) for k in range(1, 100)]
        delays.append(next(k for k in range(1, 99) if hear(reads[:k])[1]))
    assert sum(delays) / len(delays) < 10, "0.1 s"


def test_frames_that_were_owed_come_too_late_to_be_no_outage():
    """15 frames of each motor, lost in a silence: one frame counts as evidence, all of them in the mean."""
    silence = [(0.016, [1, 1, 1])]
    regular = [(0.016 + DT * k, [2, 2, 2]) for k in range(1, 20)]
    state, found = hear(silence + regular)
    assert found == []
    assert state.loss == pytest.approx(15 * FRAME / LIMITS.loss_memory, rel=0.1)
    state, found = hear([*silence, (0.018, [17, 17, 17]), *regular[1:]])
    assert found == []
    assert state.loss == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("start", [0.0, 100.0])
def test_frames_stay_owed_for_as_long_as_they_may_be_late(start):
    """However long the driver has run before: 15 frames for 20 ms, and none afterwards."""
    state, count, owed = LossState(), 0, []
    for time, came in [(0.0, 1), (0.002, 2), (0.018, 1), *((0.018 + DT * k, 2) for k in range(1, 20))]:
        count += came
        state, _ = watch_loss(state, (build(start + time, n_frame=count),), DT, FRAME, LIMITS)
        owed.append(state.owed.frames)
    n_late = round(LIMITS.late_most / DT)
    assert owed[2 : 2 + n_late] == pytest.approx([15.0] * n_late, abs=1e-6)
    assert owed[2 + n_late + 2 :] == [0.0] * (len(owed) - n_late - 4)


def test_a_silence_is_not_forgiven_twice():
    """What came too many pays for one silence, and evidence of a later loss is as strong as ever."""
    random.seed(5)
    bunch = [(0.012, [1] * 3), (0.014, [13] * 3)]
    lossy = [(0.014 + DT * k, [sum(random.random() >= 0.2 for _ in range(2)) for _ in range(3)]) for k in range(1, 100)]
    number = next(k for k in range(1, 99) if hear(bunch + lossy[:k])[1])
    assert number * DT < 0.06
