"""Gains of a winder's control, derived from its period, the cable's stiffness and the rotor's inertia."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import final

from spiraltrunk.checks import check_number
from spiraltrunk.errors import DesignError, Unquoted
from spiraltrunk.field_docs import explain_fields

CABLE_STIFFNESS = 2e4
"""Stiffness of a winder's cable up to a stop [N/m] (ours: as the simulated winders', 0.6 m of 1 mm braid)."""

LATENCY = 1.5
"""Delay of the loop over its period: one period until a torque acts, and half of one while it is held [-]."""

PHASE_MOST = 1.2
"""Largest phase that the delay may add at the resonance of rotor and cable [rad] (ours); from pi/2 damping excites."""

IMPACT = 5.0
"""Largest tension by which a winder that takes in slack may overshoot when the cable becomes taut [N] (ours)."""

_DAMPING, _WASHOUT, _SPEED, _OBSERVER, _GOVERNOR = 0.75, 1.0, 0.25, 0.5, 0.5
"""Shares of the crossover, and of the resonance for the washout [-] (ours; the margin is shown in a test)."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class WinderGains:
    """Rates of the control loop; a rate times the rotor's mass at the drum's radius, J / r^2, is a damping [N s/m]."""

    period: float
    """Period of control [s]."""
    damping: float
    """Of the resonance of rotor and cable [rad/s]."""
    washout: float
    """Below this frequency that damping vanishes, so that steady winding costs no tension [rad/s]."""
    speed: float
    """Of the speed loop inside the limit of pull [rad/s]."""
    position: float
    """Approach of the pull to its limit and to the soft limits [rad/s]."""
    reset: float
    """Integral part of the limit of pull [rad/s]."""
    observer: float
    """Bandwidth of the tension's estimate [rad/s]."""
    governor: float
    """Of the limits of speed and length, which act at once [rad/s]."""
    slack_speed: float
    """Largest speed of a slack cable: `IMPACT` = v sqrt(stiffness J) / r [m/s]."""


def derive_gains(period: float, inertia: float, radius: float, stiffness: float = CABLE_STIFFNESS) -> WinderGains:
    """Gains for a rotor [kg m^2] on a cable [N/m] at the drum's outermost radius [m].

    With the delay t = `LATENCY` * period, each loop crosses over at w_c = 1 / (2 t) at most, where an integrator with
    that delay has a phase margin of pi/2 - 1/2 = 61 deg and a gain margin of pi. Damping is at most 0.7 of critical at
    the resonance w_n = radius * sqrt(stiffness / inertia).

    Raises:
        DesignError: where a value is out of its range, or the period is too long for the resonance.
    """
    check_number("winder.period", period, least=1e-4, below=math.inf)
    check_number("winder.inertia", inertia, least=1e-7, most=10.0)
    check_number("winder.radius", radius, least=1e-3, most=1.0)
    check_number("winder.stiffness", stiffness, least=1.0, most=1e7)
    resonance, latency = radius * math.sqrt(stiffness / inertia), LATENCY * period
    if resonance * latency > PHASE_MOST:
        most = PHASE_MOST / (LATENCY * resonance)
        raise DesignError(
            "winder.period", got=Unquoted(f"{1e3 * period:g} ms"),
            allowed=f"at most {math.floor(1e4 * most) / 10:g} ms: "
            f"rotor and cable resonate at {resonance / (2 * math.pi):.3g} Hz; "
            "a shorter period, a smaller drum or a softer cable",
        )  # fmt: skip
    check_number("winder.period", period, most=0.1)
    crossover = 1 / (2 * latency)
    speed = _SPEED * crossover
    return WinderGains(
        period=period, damping=min(_DAMPING * crossover, 1.4 * resonance), washout=_WASHOUT * resonance, speed=speed,
        position=speed / 4, reset=speed / 8, observer=_OBSERVER * crossover, governor=_GOVERNOR * crossover,
        slack_speed=IMPACT * radius / math.sqrt(stiffness * inertia),
    )  # fmt: skip
