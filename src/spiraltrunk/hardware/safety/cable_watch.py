"""Watches of the cable: slack or broken, slipping, tangled, too tight, too long or too short."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from spiraltrunk.field_docs import explain_fields
from spiraltrunk.hardware.safety.fault import FaultKind
from spiraltrunk.hardware.safety.limits import SafetyLimits
from spiraltrunk.hardware.safety.reading import CableRange, CableReading, Finding


@explain_fields
@final
@dataclass(frozen=True, kw_only=True, slots=True)
class SlackState:
    """Load of a cable, and where the other cables say that it is taut."""

    load: float = 0.0
    """Mean tension [N]."""
    elapsed: float = 0.0
    """Time without load [s]."""
    told: float = 0.0
    """Length that the others told while all carried load, a mean [m]."""
    offset: float = 0.0
    """Length beyond it at which this cable was taut then [m]."""
    tension: float = 0.0
    """Sum of the tensions of all cables then [N]."""


def compute_shape_weights(directions: Sequence[Sequence[float]]) -> tuple[tuple[float, ...], ...]:
    """Weights with which the pulls of the other cables tell that of each cable, shape (n_cable, n_cable) [-].

    Cable c with direction d_c across the trunk takes in l_c = d_c . b for a bend b, to first order. The others give b
    by least squares, of least norm where they do not span the plane: w_c = d_c pinv(D_others), and 0 for itself.

    Args:
        directions: unit vectors across the trunk, shape (n_cable, 2) [-].
    """
    across = np.asarray(directions, dtype=float)
    rows = []
    for cable in range(len(across)):
        others = np.delete(across, cable, axis=0)
        weights = across[cable] @ np.linalg.pinv(others)
        rows.append(tuple(np.insert(weights, cable, 0.0).tolist()))
    return tuple(rows)


def watch_slack(
    state: SlackState, cable: tuple[CableReading, CableRange], told: float, dt: float, limits: SafetyLimits
) -> tuple[SlackState, Finding | None]:
    """A cable that was wound in beyond its length on the trunk and carries no load: it is broken, or off its drum.

    Without load the floor of tension winds a drum in. When a trunk uncurls or swings faster than that, cables are slack
    for seconds: nominal, and they become taut at the length that the other cables tell, or before. A broken cable goes
    on. `watch_length` follows in each period in which all cables carry load.

    Args:
        state: state after the period before.
        cable: its reading, and what it may do.
        told: its length by the pulls of the others, see `compute_shape_weights` [m]. One of them that is slack itself
            makes it too long, which delays the fault and raises no false one.
        dt: period [s].
        limits: when it is a fault.
    """
    reading, allowed_range = cable
    load = state.load + min(1.0, dt / limits.slack_memory) * (reading.tension - state.load)
    is_loaded = load >= limits.slack_part * allowed_range.tension_least
    elapsed = 0.0 if is_loaded else state.elapsed + dt
    after = replace(state, load=load, elapsed=elapsed)
    excess = reading.pull - told - state.offset
    allowed = limits.slack_length + limits.slack_part_moved * abs(told - state.told)
    if is_loaded or elapsed < limits.slack_time or excess < allowed:
        return after, None
    text = f"{1e3 * excess:.1f} mm more than the other cables tell came in with a load of {load:.2f} N"
    return after, Finding(FaultKind.SLACK, f"{text}; allowed: {1e3 * allowed:.1f} mm")


def has_moved(states: Sequence[SlackState], told: Sequence[float], limits: SafetyLimits) -> bool:
    """Whether the trunk has moved by `settle_length` since lengths were followed; ``told`` is of each cable [m]."""
    return any(abs(new - state.told) > limits.settle_length for state, new in zip(states, told, strict=True))


def watch_length(
    state: SlackState, lengths: tuple[float, float], tension: float, dt: float | None, limits: SafetyLimits
) -> tuple[SlackState, Finding | None]:
    """Length of a cable while all carry load: one that grows by a step against the others has slipped on its drum.

    Told and measured length are followed with the time constant `settle_time`, or at once when the trunk `has_moved`;
    the step is what is left beyond what bending and stretching explain.

    Args:
        state: state after `watch_slack`.
        lengths: pull of this cable, and its length by the pulls of the others [m].
        tension: sum of the tensions of all cables [N].
        dt: period [s]; None follows at once.
        limits: when it is a fault.
    """
    pull, told = lengths
    excess = pull - told - state.offset
    elastic = limits.compliance * max(0.0, tension - state.tension)
    allowed = limits.step_length + limits.step_part_moved * abs(told - state.told) + elastic
    share = 1.0 if dt is None else min(1.0, dt / limits.settle_time)
    after = replace(
        state,
        told=state.told + share * (told - state.told),
        offset=state.offset + share * excess,
        tension=state.tension + share * (tension - state.tension),
    )
    if dt is None or excess < allowed:
        return after, None
    text = f"{1e3 * excess:.1f} mm more than the other cables tell came in under load"
    return after, Finding(FaultKind.CABLE_SLIP, f"{text}; allowed: {1e3 * allowed:.1f} mm")


@explain_fields
@final
@dataclass(frozen=True, kw_only=True, slots=True)
class SlipState:
    """Tension and length before a dip."""

    tension: float = 0.0
    """Latest tension, falling no faster than `SafetyLimits.slip_rate`; in a dip that before it [N]."""
    pull: float | None = None
    """Least cable wound in since the dip began [m]; None outside of a dip."""
    elapsed: float = 0.0
    """Time since the dip began [s]."""


def watch_slip(
    state: SlipState, reading: CableReading, dt: float, limits: SafetyLimits
) -> tuple[SlipState, Finding | None]:
    """A cable that slips on its drum, out of its knot, or breaks: the tension dips and a burst of it is wound in.

    Up to then a slip and a break look alike. A dip is faster than `slip_rate` and deeper than `slip_tension` and
    `slip_part`; it ends when the tension comes back, or after `slip_time`.
    """
    before = state.tension if state.pull is not None else state.tension - limits.slip_rate * dt
    before = max(reading.tension, before)
    is_dip = before - reading.tension >= max(limits.slip_tension, limits.slip_part * before)
    if not is_dip or state.elapsed >= limits.slip_time:
        return SlipState(tension=before if state.pull is None else reading.tension), None
    start = reading.pull if state.pull is None else min(state.pull, reading.pull)
    after = SlipState(tension=before, pull=start, elapsed=state.elapsed + dt)
    if reading.pull - start < limits.slip_length:
        return after, None
    text = f"{1e3 * (reading.pull - start):.1f} mm came in while the tension fell to {reading.tension:.1f} N"
    allowed = f"allowed: {1e3 * limits.slip_length:g} mm"
    return after, Finding(FaultKind.CABLE_SLIP, f"{text}; {allowed}")


@explain_fields
@final
@dataclass(frozen=True, kw_only=True, slots=True)
class TangleState:
    """Tension and length when paying out began."""

    pull: float | None = None
    """Cable wound in then [m]; None while nothing is paid out."""
    tension: float = 0.0
    """Tension then [N]."""


def watch_tangle(
    state: TangleState, reading: CableReading, drag: float, limits: SafetyLimits
) -> tuple[TangleState, Finding | None]:
    """A drum that pays out and tightens: the cable is caught between layers, or winds on the wrong way.

    A trunk that pulls cable out raises the tension to its command and the winder's ``drag`` [N s/m] times the speed,
    and no further, because the winder yields.
    """
    if reading.speed >= 0.0:
        return TangleState(), None
    if state.pull is None:
        return TangleState(pull=reading.pull, tension=reading.tension), None
    rise = reading.tension - max(state.tension, reading.tension_wanted) - drag * abs(reading.speed)
    out = state.pull - reading.pull
    if out < limits.tangle_length or rise < limits.tangle_tension:
        return state, None
    text = f"the tension rose by {rise:.1f} N while {1e3 * out:.1f} mm were paid out"
    return state, Finding(FaultKind.TANGLED_DRUM, f"{text}; allowed: {limits.tangle_tension:g} N")


def watch_tension(
    elapsed: float, reading: CableReading, dt: float, ceiling: float, limits: SafetyLimits
) -> tuple[float, Finding | None]:
    """A tension beyond its ceiling, for too long or by far; the state is for how long [s]."""
    if reading.tension <= (1.0 + limits.over_part) * ceiling:
        return 0.0, None
    elapsed += dt
    if elapsed < limits.over_time and reading.tension < (1.0 + limits.over_part_at_once) * ceiling:
        return elapsed, None
    return elapsed, Finding(FaultKind.OVER_TENSION, f"the tension is {reading.tension:.1f} N; allowed: {ceiling:g} N")


def find_too_far(reading: CableReading, allowed: CableRange, limits: SafetyLimits) -> Finding | None:
    """A length beyond what the design allows."""
    least, most = allowed.pull_least - limits.length_margin, allowed.pull_most + limits.length_margin
    if least <= reading.pull <= most:
        return None
    span = f"{1e3 * allowed.pull_least:.0f} to {1e3 * allowed.pull_most:.0f} mm"
    return Finding(FaultKind.LENGTH_LIMIT, f"{1e3 * reading.pull:.1f} mm of cable are wound in; allowed: {span}")
