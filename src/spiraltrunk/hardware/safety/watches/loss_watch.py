"""Watch of lost feedback: it counts the frames that arrived against those that were due, however bunched they come.

A host, an adapter or a board that is late delivers in bunches: nothing for some time, then several frames of every
motor at once, perhaps in several portions. Counted between two reads, such frames would be lost first and too many
later. So frames are due by the time between two *arrivals*, and where no motor was heard for `_SILENCE` frames, those
of the silence may still be on the way: they are owed, and what comes too many afterwards is taken from them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple, final

from spiraltrunk.field_docs import explain_fields
from spiraltrunk.hardware.motors.motor_port import MotorState
from spiraltrunk.hardware.safety.fault import FaultKind
from spiraltrunk.hardware.safety.limits import SafetyLimits
from spiraltrunk.hardware.safety.reading import Finding

_OUTAGE = 2
"""Periods in a row without feedback of a motor from which its losses are not independent [-] (ours)."""

_SILENCE = 1.5
"""Frames that no motor sends in time from which they count as owed and not as lost [-] (ours): three motors that lose
20 % each are silent for two frames once in 16 s."""


class _Heard(NamedTuple):
    """What distinguishes new feedback of a motor from old."""

    time: float
    """Its arrival [s]."""
    n_frame: int | None
    """Frames up to then [-]."""
    missed: int = 0
    """Periods in a row without new feedback [-]."""


class _Owed(NamedTuple):
    """Frames of each motor from a silence of all, which may still come."""

    frames: float = 0.0
    """How many [-]."""
    since: float = 0.0
    """End of the silence [s]."""


_NONE = _Owed()


@explain_fields
@final
@dataclass(frozen=True, kw_only=True, slots=True)
class LossState:
    """How much of the feedback of all motors, which share a bus, is lost."""

    heard: tuple[_Heard, ...] = ()
    """Latest feedback of each motor; empty before the first period."""
    owed: _Owed = _NONE
    """What a silence of all motors left open."""
    evidence: float = 0.0
    """Cumulated log-likelihood ratio, never negative [-]."""
    loss: float = 0.0
    """Mean part of the feedback that is lost [-]."""

    @property
    def arrival(self) -> float:
        """Latest arrival of any motor's feedback [s]."""
        return max(heard.time for heard in self.heard)


class _Count(NamedTuple):
    """Frames of one period of control."""

    due: float
    """Due of each motor [-]."""
    lost: tuple[float, ...]
    """Of those, lost, per motor; negative where more came than were due [-]."""
    period: float
    """Time between two frames [s]."""
    owed: _Owed = _NONE
    """What is owed afterwards."""
    forgiven: float = 0.0
    """Owed by each motor for too long: an outage [-]."""


def watch_loss(
    state: LossState, motors: tuple[MotorState, ...], dt: float, period: float | None, limits: SafetyLimits
) -> tuple[LossState, tuple[tuple[int | None, Finding], ...]]:
    """Feedback that misses too many periods of control, in a row or on the average.

    The sum S of log(p1/p0) for each frame that is lost and log((1-p1)/(1-p0)) for each that arrives, kept at 0 or
    above (Page's cumulative sum test, Biometrika 41, 1954), tells a loss p1 = `loss_stopped` from p0 = `loss_warned`
    with the least mean delay for a given rate of false alarms. Where motors send by themselves, the time between two
    arrivals over ``period`` is due; else one frame in each period of control. The losses of an outage are not
    independent: of one motor's the first period counts in S, of one of all motors a single frame, and `missed_cycles`
    is the limit for both.

    Args:
        state: state after the period before.
        motors: feedback of all motors.
        dt: period of control [s].
        period: period of the feedback [s], None where it is asked for.
        limits: when it is a fault.

    Returns:
        The next state, and what was found, each with its motor or None for all.
    """
    if not state.heard:
        return LossState(heard=tuple(_Heard(motor.time, motor.n_frame) for motor in motors)), ()
    heard = tuple(
        _Heard(motor.time, motor.n_frame, old.missed + 1 if motor.time == old.time else 0)
        for motor, old in zip(motors, state.heard, strict=True)
    )
    came = _count_arrived(motors, state.heard)
    if period is None or came is None:
        count = _Count(1.0, tuple(float(one.missed > 0) for one in heard), dt)
    else:
        count = _count_frames(state, came, max(motor.time for motor in motors), period, limits)
    evidence, loss = _weigh(state, heard, count, limits)
    after = LossState(heard=heard, owed=count.owed, evidence=evidence, loss=loss)
    return after, _find_loss(after, limits)


def _count_arrived(motors: tuple[MotorState, ...], heard: tuple[_Heard, ...]) -> tuple[int, ...] | None:
    """New frames of each motor [-]; None where they are not counted."""
    came = []
    for motor, old in zip(motors, heard, strict=True):
        if motor.n_frame is None or old.n_frame is None:
            return None
        came.append(motor.n_frame - old.n_frame)
    return tuple(came)


def _count_frames(
    state: LossState, came: tuple[int, ...], arrival: float, period: float, limits: SafetyLimits
) -> _Count:
    """Frames that were due since the latest arrival and did not come; what a silence of all explains is owed."""
    due = (arrival - state.arrival) / period
    common, owed, forgiven = due - max(came), state.owed, 0.0
    if owed.frames and arrival - owed.since > limits.late_most:
        owed, forgiven = _NONE, owed.frames
    if common >= _SILENCE:
        shift, since = common, arrival
    else:
        shift, since = -min(owed.frames, max(0.0, -common)), owed.since
    lost = tuple(due - shift - one for one in came)
    return _Count(due, lost, period, _Owed(owed.frames + shift, since), forgiven)


def _weigh(state: LossState, heard: tuple[_Heard, ...], count: _Count, limits: SafetyLimits) -> tuple[float, float]:
    """The next evidence and mean loss; a motor within an outage counts in the mean alone."""
    p0, p1 = limits.loss_warned, limits.loss_stopped
    per_lost, per_come = math.log(p1 / p0), math.log((1.0 - p1) / (1.0 - p0))
    ratio = per_lost if count.forgiven else 0.0
    for one, lost in zip(heard, count.lost, strict=True):
        if one.missed < _OUTAGE:
            came = max(0.0, count.due - lost) if count.due else 0.0
            ratio += lost * per_lost + came * per_come
    share = min(1.0, count.period / limits.loss_memory)
    lost_mean = sum(count.lost) / len(heard) + count.forgiven
    loss = state.loss + share * (lost_mean - state.loss * count.due)
    return max(0.0, state.evidence + ratio), min(1.0, max(0.0, loss))


def _find_loss(state: LossState, limits: SafetyLimits) -> tuple[tuple[int | None, Finding], ...]:
    """Faults that the state of the loss amounts to, each with its motor; None for all motors."""
    found: list[tuple[int | None, Finding]] = []
    for motor, heard in enumerate(state.heard):
        if heard.missed >= limits.missed_cycles:
            text = f"{heard.missed} periods in a row without feedback; allowed: below {limits.missed_cycles}"
            found.append((motor, Finding(FaultKind.STALE_FEEDBACK, text)))
    if state.evidence >= limits.loss_evidence:
        text = f"about {limits.loss_stopped:.0%} of the feedback is lost; allowed: {limits.loss_warned:.0%}"
        found.append((None, Finding(FaultKind.STALE_FEEDBACK, text)))
    return tuple(found)
