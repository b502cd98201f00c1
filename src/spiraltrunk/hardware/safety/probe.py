"""Probe at the start of homing: one motor after another gets a small pulse, and only its own feedback may answer.

It finds exchanged identifiers, a motor that does not obey, and one whose torque has the wrong sign, before any cable
is loaded. The pulse is of the order of the dry friction, and too short to wind in more than a few millimetres.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, final

from spiraltrunk.field_docs import explain_fields
from spiraltrunk.hardware.safety.fault import FaultKind
from spiraltrunk.hardware.safety.reading import Finding

TORQUE: Final = 0.04
"""Torque of a pulse [N m] (ours): 2 N on a drum of 20 mm."""

PERIOD: Final = 0.040
"""Time of a pulse, and of the rest before it [s] (ours); 0.2 rad of a GM6020 without friction. Each lasts longer where
a long period of control leaves no sample in it."""

SETTLING: Final = 0.020
"""Time at the start of each in which the torque settles and nothing is averaged [s] (ours)."""

ANSWER: Final = 0.3
"""Part of the pulse that the motor itself must report at least, and every other at most [-] (ours)."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True, slots=True)
class ProbeState:
    """How far the probe is."""

    motor: int = 0
    """Motor that is probed; the number of motors when all are."""
    elapsed: float = 0.0
    """Time since its rest began [s]; `PERIOD` where the pulse begins."""
    rest: tuple[float, ...] = ()
    """Sum of the reported torque of each motor in the rest [N m]."""
    pulse: tuple[float, ...] = ()
    """The same in the pulse [N m]."""
    n_rest: int = 0
    """Number of values in the first sum [-]."""
    n_pulse: int = 0
    """Number of values in the second [-]."""


def probe_torques(state: ProbeState, n_motor: int) -> tuple[float, ...]:
    """Torques of this period [N m]."""
    return tuple(TORQUE if _is_pulse(state) and motor == state.motor else 0.0 for motor in range(n_motor))


def step_probe(
    state: ProbeState, reported: Sequence[float], dt: float
) -> tuple[ProbeState, tuple[int, Finding] | None]:
    """Advance by one period with the reported torques [N m]; what is wrong comes with its motor."""
    elapsed = state.elapsed + dt
    zeros = (0.0,) * len(reported)
    rest, pulse = state.rest or zeros, state.pulse or zeros
    n_rest, n_pulse = state.n_rest, state.n_pulse
    if not _is_pulse(state):
        if state.elapsed >= SETTLING:
            rest, n_rest, elapsed = _add(rest, reported), n_rest + 1, min(elapsed, PERIOD)
    elif state.elapsed >= PERIOD + SETTLING:
        pulse, n_pulse = _add(pulse, reported), n_pulse + 1
    after = ProbeState(
        motor=state.motor, elapsed=elapsed, rest=rest, pulse=pulse, n_rest=n_rest, n_pulse=n_pulse
    )  # fmt: skip
    if elapsed < 2.0 * PERIOD or not n_pulse:
        return after, None
    answers = [p / n_pulse - r / n_rest for p, r in zip(pulse, rest, strict=True)]
    finding = check_answers(state.motor, answers)
    return ProbeState(motor=state.motor + 1), None if finding is None else (state.motor, finding)


def _is_pulse(state: ProbeState) -> bool:
    """Whether the rest is over."""
    return state.elapsed >= PERIOD and state.n_rest > 0


def check_answers(motor: int, answers: Sequence[float]) -> Finding | None:
    """Check the answers of all motors [N m] to the pulse of one of them."""
    least = ANSWER * TORQUE
    strangers = [other for other, answer in enumerate(answers) if other != motor and abs(answer) > least]
    if strangers:
        text = f"the pulse of motor {motor + 1} was answered by motor {strangers[0] + 1}; check the ids"
        return Finding(FaultKind.IMPLAUSIBLE_FEEDBACK, text)
    if answers[motor] < -least:
        text = f"motor {motor + 1} pulls the wrong way; check its direction"
        return Finding(FaultKind.IMPLAUSIBLE_FEEDBACK, text)
    if answers[motor] < least:
        text = f"motor {motor + 1} answered a pulse of {TORQUE:g} N m by {answers[motor]:.3f} N m; check its mode"
        return Finding(FaultKind.IMPLAUSIBLE_FEEDBACK, text)
    return None


def _add(sums: tuple[float, ...], values: Sequence[float]) -> tuple[float, ...]:
    """Sums with one value more each."""
    return tuple(total + value for total, value in zip(sums, values, strict=True))
