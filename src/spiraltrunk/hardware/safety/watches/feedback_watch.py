"""Watches of the feedback: whether it is stale, frozen or implausible.

Each is a pure function from a state, the readings and the limits to the next state and what was found.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple, final

from spiraltrunk.field_docs import explain_fields
from spiraltrunk.hardware.motors.motor_port import MotorDataSheet, MotorState
from spiraltrunk.hardware.safety.fault import FaultKind
from spiraltrunk.hardware.safety.limits import SafetyLimits
from spiraltrunk.hardware.safety.reading import CableReading, Finding


def find_stale(motor: MotorState | None, now: float, limits: SafetyLimits) -> Finding | None:
    """Feedback that never came, or is older than `SafetyLimits.feedback_age`."""
    if motor is None:
        return Finding(FaultKind.STALE_FEEDBACK, "no feedback has come; check supply, bus and id")
    if not now - motor.time < limits.feedback_age:
        allowed = f"allowed: below {1e3 * limits.feedback_age:g} ms"
        return Finding(FaultKind.STALE_FEEDBACK, f"the feedback is {1e3 * (now - motor.time):.1f} ms old; {allowed}")
    return None


def find_impossible(motor: MotorState, sheet: MotorDataSheet, limits: SafetyLimits) -> Finding | None:
    """A value that no motor can have: not finite, or far beyond the data sheet."""
    values = (motor.time, motor.angle, motor.speed, motor.torque, motor.temperature)
    if not all(map(math.isfinite, values)) or not math.isfinite(motor.voltage or 0.0):
        return Finding(FaultKind.IMPLAUSIBLE_FEEDBACK, f"the feedback {values} is not finite")
    for name, value, most in (("speed", motor.speed, sheet.speed_max), ("torque", motor.torque, sheet.torque_max)):
        if abs(value) > 2.0 * most:
            text = f"the {name} is {value:.3g}; allowed by the data sheet: up to {most:.3g}"
            return Finding(FaultKind.IMPLAUSIBLE_FEEDBACK, text)
    if not limits.temperature_least <= motor.temperature <= limits.temperature_most:
        allowed = f"plausible: {limits.temperature_least:g} to {limits.temperature_most:g}"
        text = f"the temperature is {motor.temperature:g} degC; {allowed}"
        return Finding(FaultKind.IMPLAUSIBLE_FEEDBACK, text)
    return None


class _Frame(NamedTuple):
    """Values of a frame; on a working motor, one of them changes sooner or later."""

    angle: float
    speed: float
    torque: float


class Noise(NamedTuple):
    """How often the reported torque of a motor at rest changes although none is commanded."""

    n_quiet: int = 0
    """New frames in a row without commanded torque [-]."""
    n_frame: int = 0
    """Frames counted, those after the first `_SETTLING` of each row [-]."""
    n_changed: int = 0
    """Of those, frames whose torque differs from that of the frame before [-]."""

    @property
    def is_fluctuating(self) -> bool:
        """Whether the last digit of the torque is known to fluctuate at rest."""
        return self.n_frame >= LEAST_FRAMES and self.n_changed >= LEAST_CHANGED * self.n_frame


_SILENT = Noise()

_SETTLING = 10
"""Frames without commanded torque before a motor is at rest [-] (ours): 20 ms at 500 Hz."""

LEAST_FRAMES = 40
"""Frames that show whether a motor's feedback fluctuates [-] (ours); the probe of homing gives 80 at 500 Hz."""

LEAST_CHANGED = 0.5
"""Part of them that must differ from the frame before [-] (ours)."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True, slots=True)
class FrozenState:
    """How long the feedback of a motor has been equal."""

    time: float = -math.inf
    """Arrival of the latest feedback [s]."""
    frame: _Frame | None = None
    """Its values; None before the first."""
    least: float = math.inf
    """Least torque commanded since these values came [N m]."""
    most: float = -math.inf
    """Largest torque commanded since these values came [N m]."""
    equal: int = 0
    """New frames with the same values [-]."""
    repeated: int = 0
    """New frames with the same values although a change was due [-]."""
    noise: Noise = _SILENT
    """How much the feedback fluctuates at rest."""


def watch_frozen(state: FrozenState, reading: CableReading, limits: SafetyLimits) -> tuple[FrozenState, Finding | None]:
    """Frozen feedback: new frames arrive, but their values do not change although they must.

    A motor cannot send equal frames while it says that it turns at `stall_speed`, nor after its commanded torque has
    changed by `frozen_torque`, which its own estimate must follow. Under a constant torque the last digit of some
    motors' estimates fluctuates. Which motors do so is learnt while no torque is commanded, in the probe of homing. For
    these, `frozen_still` equal frames in a row are a fault, too. Where q is the share of frames that repeat the one
    before, q <= 1 - `LEAST_CHANGED`, that happens by chance with q^`frozen_still` = 8e-31 at each frame.
    """
    motor = reading.motor
    if motor.time == state.time:
        return state, None
    frame, noise = _Frame(motor.angle, motor.speed, motor.torque), _update_noise(state, reading)
    if frame != state.frame:
        torque = reading.torque
        return FrozenState(time=motor.time, frame=frame, least=torque, most=torque, noise=noise), None
    least, most, equal = min(state.least, reading.torque), max(state.most, reading.torque), state.equal + 1
    is_due = most - least >= limits.frozen_torque or abs(motor.speed) >= limits.stall_speed
    repeated = state.repeated + 1 if is_due else 0
    after = FrozenState(
        time=motor.time, frame=frame, least=least, most=most, equal=equal, repeated=repeated, noise=noise
    )
    if repeated >= limits.frozen_frames:
        text = f"{repeated} frames are equal while the commanded torque went from {least:.3f} to {most:.3f} N m"
        return after, Finding(FaultKind.FROZEN_FEEDBACK, f"{text} and the speed is {motor.speed:.2f} rad/s")
    if noise.is_fluctuating and equal >= limits.frozen_still:
        text = f"{equal} frames in a row are equal; at rest {noise.n_changed} of {noise.n_frame} differed from the last"
        return after, Finding(FaultKind.FROZEN_FEEDBACK, text)
    return after, None


def _update_noise(state: FrozenState, reading: CableReading) -> Noise:
    """The noise after a new frame, which counts once `_SETTLING` frames came without commanded torque."""
    noise = state.noise
    if reading.torque != 0.0 or state.frame is None:
        return noise._replace(n_quiet=0)
    if noise.n_quiet < _SETTLING:
        return noise._replace(n_quiet=noise.n_quiet + 1)
    is_changed = reading.motor.torque != state.frame.torque
    return Noise(noise.n_quiet + 1, noise.n_frame + 1, noise.n_changed + is_changed)


@explain_fields
@final
@dataclass(frozen=True, kw_only=True, slots=True)
class MotionState:
    """Angle and integrated speed since the start of a window."""

    time: float = math.nan
    """Arrival of the latest feedback [s]; NaN before the first."""
    angle: float = 0.0
    """Its angle [rad]."""
    speed: float = 0.0
    """Its speed [rad/s]."""
    start: float = 0.0
    """Start of the window [s]."""
    turned: float = 0.0
    """Change of the angle since then [rad]."""
    expected: float = 0.0
    """Integral of the speed since then [rad]."""


def watch_motion(
    state: MotionState, motor: MotorState, sheet: MotorDataSheet, limits: SafetyLimits
) -> tuple[MotionState, Finding | None]:
    """An angle that jumps, which loses the count of turns, or whose change differs from the integrated speed."""
    if motor.is_count_lost:
        text = "turns may have been missed in a silence or at a jump; home the drums again"
        return MotionState(), Finding(FaultKind.COUNT_LOST, text)
    if math.isnan(state.time):
        return MotionState(time=motor.time, angle=motor.angle, speed=motor.speed, start=motor.time), None
    if motor.time == state.time:
        return state, None
    dt = motor.time - state.time
    step = motor.angle - state.angle
    allowed = limits.jump_angle + limits.jump_speeds * sheet.speed_max * dt
    if not abs(step) <= allowed:
        text = f"the angle jumped by {step:.2f} rad in {1e3 * dt:.1f} ms; possible: {allowed:.2f} rad"
        return MotionState(), Finding(FaultKind.COUNT_LOST, text)
    return _compare_motion(state, motor, step, limits)


def _compare_motion(
    state: MotionState, motor: MotorState, step: float, limits: SafetyLimits
) -> tuple[MotionState, Finding | None]:
    """The window with one frame more; at its end angle and speed are compared, and the next window begins."""
    turned = state.turned + step
    expected = state.expected + 0.5 * (state.speed + motor.speed) * (motor.time - state.time)
    common = {"time": motor.time, "angle": motor.angle, "speed": motor.speed}
    if motor.time - state.start < limits.speed_window:
        return MotionState(**common, start=state.start, turned=turned, expected=expected), None
    allowed = limits.speed_error + limits.speed_error_part * max(abs(expected), abs(turned))
    after = MotionState(**common, start=motor.time)
    if abs(turned - expected) <= allowed:
        return after, None
    text = f"the angle turned by {turned:.2f} rad where the speed says {expected:.2f}; allowed: {allowed:.2f} apart"
    return after, Finding(FaultKind.IMPLAUSIBLE_FEEDBACK, text)


def watch_swap(
    state: tuple[float, ...], readings: tuple[CableReading, ...], dt: float, limits: SafetyLimits
) -> tuple[tuple[float, ...], tuple[int, Finding] | None]:
    """Feedback of two motors exchanged: each reports the torque that was commanded to the other.

    For each pair (i, j) of motors with reported torques m and commanded torques c, the sum of
    |m_i - c_i| + |m_j - c_j| - |m_i - c_j| - |m_j - c_i| - `swap_torque` over time, kept at 0 or above. By the
    rearrangement inequality it never grows as long as m = s c with any scale s > 0, so that the scale of the reported
    torque, which no data sheet gives, does not matter.

    Args:
        state: the sum of each pair [N m s]; empty at the start.
        readings: of all cables.
        dt: period [s].
        limits: when it is a fault.

    Returns:
        The next state, and the first motor of a pair with what was found.
    """
    pairs = [(i, j) for i in range(len(readings)) for j in range(i)]
    sums = []
    for (i, j), before in zip(pairs, state or (0.0,) * len(pairs), strict=True):
        m_i, m_j = readings[i].motor.torque, readings[j].motor.torque
        c_i, c_j = readings[i].torque, readings[j].torque
        gain = abs(m_i - c_i) + abs(m_j - c_j) - abs(m_i - c_j) - abs(m_j - c_i)
        sums.append(max(0.0, before + (gain - limits.swap_torque) * dt))
    for (i, j), total in zip(pairs, sums, strict=True):
        if total > limits.swap_impulse:
            text = f"motors {j + 1} and {i + 1} report each other's torques; check the ids"
            return tuple(sums), (j, Finding(FaultKind.IMPLAUSIBLE_FEEDBACK, text))
    return tuple(sums), None
