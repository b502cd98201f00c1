"""Dither: an alternating torque that takes away the dead band of dry friction, where a cable is let down or homed.

A rotor at rest holds any tension that differs from its force by less than the dry friction. A square wave of an
amplitude above the friction moves the rotor to and fro by some hundredths of a millimetre of cable, and the mean
tension follows the mean force: friction acts as damping (smoothing of Coulomb friction; Armstrong-Helouvry, Dupont and
Canudas de Wit, Automatica 30, 1994). An amplitude that falls to zero leaves the tension where it is. Where the true
friction is above the amplitude, a dead band of their difference is left.

A stir is one dither of a larger amplitude at whatever tension, of a drum that stands while others bend the trunk. It
shows whether the drum is stuck, see `watch_stall`: a torque A M of amplitude A over the friction M turns a free rotor
of inertia J to and fro by (A - 1) M t^2 / (4 J) in half a cycle t, which the encoder sees, and a stuck one not at all.
The cable hardly feels it, for the rotor moves by less than a tenth of a millimetre. Motors whose period is too long are
not stirred, see `can_stir`: their estimate of the tension would take the alternating torque for tension.
Nothing here was tried on a real motor.
"""

from __future__ import annotations

from typing import Final, NamedTuple, final

HALF_TIME: Final = 0.008
"""Half a cycle [s] (ours: 62 Hz, above the resonance of 18 Hz of a GM6020 and a cable of 2e4 N/m)."""

SEEN_STEPS, SEEN_PERIODS = 6.0, 3
"""Steps of the encoder by which a stir must turn the rotor, and periods in half a cycle [-] (ours: with twice the
friction it turns by half as many steps, which is more than the watch of stalls takes for none)."""

AMPLITUDE: Final = 2.0
"""Amplitude over the dry friction when a cable is let down [-] (ours: the true friction may be twice the assumed)."""

STIR: Final = 3.0
"""Amplitude over the dry friction of a stir [-] (ours: a rotor with twice the assumed friction turns)."""

FADE_TIME: Final = 0.5
"""Time in which that falls to zero [s] (ours)."""

RESTART_LENGTH: Final = 3e-4
"""Cable paid out that starts it anew [m] (ours: several times the motion of the dither itself)."""


@final
class Dither(NamedTuple):
    """Dither of one period."""

    share: float = 0.0
    """Amplitude over that at the start, 1 to 0 [-]."""
    phase: int = 0
    """Periods of control since the cycle began [-]."""
    pull: float = 0.0
    """Pull from which paying out is counted: that at the start, or the largest since [m]."""
    stir: float = 0.0
    """Amplitude of a stir over that at its start, 1 to 0 [-]."""


def step_dither(
    before: Dither, pull: float, dt: float, n_half: int, *, is_let_down: bool, is_stirred: bool = False
) -> Dither:
    """Start anew where the cable is let down or paid out, or stirred, else fade; ``n_half`` periods make half a cycle.

    A cable that is wound in starts nothing: there, friction is compensated. A stir starts in the middle of a half, so
    that the rotor swings about where it was.
    """
    phase = n_half // 2 if is_stirred else (before.phase + 1) % (2 * n_half)
    stir = 1.0 if is_stirred else max(0.0, before.stir - dt / FADE_TIME)
    if is_let_down or pull < before.pull - RESTART_LENGTH:
        return Dither(1.0, phase, pull, stir)
    return Dither(max(0.0, before.share - dt / FADE_TIME), phase, max(before.pull, pull), stir)


def count_half(period: float) -> int:
    """Periods of control in half a cycle [-]."""
    return max(1, round(HALF_TIME / period))


def can_stir(period: float, inertia: float, friction: float, angle_step: float) -> bool:
    """Whether a stir is seen by the encoder and told from tension.

    Args:
        period: period of control [s].
        inertia: the rotor's [kg m^2].
        friction: the rotor's [N m].
        angle_step: the encoder's resolution [rad].
    """
    n_half = count_half(period)
    turned = (STIR - 1.0) * friction * (n_half * period) ** 2 / (4.0 * inertia)
    return n_half >= SEEN_PERIODS and turned >= SEEN_STEPS * angle_step


def compute_amplitude(dither: Dither, above: float, friction: float) -> float:
    """Amplitude over the dry friction [-]: all at the floor, none where a torque ``above`` it exceeds the friction.

    A cable that holds something is left at rest, unless it is stirred. Torque and friction are in N m.
    """
    let_down = AMPLITUDE * dither.share * max(0.0, 1.0 - above / max(friction, 1e-9))
    return max(let_down, STIR * dither.stir)


def compute_sign(dither: Dither, n_half: int) -> float:
    """1 in the first half of a cycle, -1 in the second [-]."""
    return 1.0 if dither.phase < n_half else -1.0
