"""Watches of the load cells: silent, stuck, or against what the motor tells."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import final

from spiraltrunk.field_docs import explain_fields
from spiraltrunk.hardware.safety.fault import FaultKind
from spiraltrunk.hardware.safety.limits import SafetyLimits
from spiraltrunk.hardware.safety.reading import CableRange, CableReading, Finding


def find_silent_cell(age_max: float) -> Finding:
    """A cell without a plausible new reading for ``age_max`` [s]."""
    return Finding(FaultKind.LOAD_CELL, f"no plausible reading of its load cell for {1e3 * age_max:g} ms")


@explain_fields
@final
@dataclass(frozen=True, kw_only=True, slots=True)
class StillState:
    """Since when a cell repeats itself."""

    tension: float = math.nan
    """Latest reading [N]; NaN before the first."""
    since: float = math.inf
    """When it came first [s]."""


def watch_still(
    state: StillState, tension: float, time: float, limits: SafetyLimits
) -> tuple[StillState, Finding | None]:
    """A cell that tells the same number again and again: stuck amplifier, broken wire, saturated converter.

    The last digits of a working amplifier fluctuate, also with a slack cable. Only new readings count; without any the
    cell becomes silent before.

    Args:
        state: state after the reading before.
        tension: latest reading [N].
        time: when it arrived [s].
        limits: when it is a fault.
    """
    if tension != state.tension:
        return StillState(tension=tension, since=time), None
    if time - state.since < limits.cell_still:
        return state, None
    text = f"its load cell has told {tension:.4g} N without any change for {time - state.since:.1f} s"
    return state, Finding(FaultKind.LOAD_CELL, f"{text}; allowed: {limits.cell_still:g} s")


@explain_fields
@final
@dataclass(frozen=True, kw_only=True, slots=True)
class CellState:
    """For how long a load cell and its motor have not gone together."""

    apart: float = 0.0
    """Time for which they differed by more than is allowed, or the cable pushed [s]."""
    beyond: float = 0.0
    """Time for which the winder's loss stood at its bound [s]."""


def watch_cell(
    state: CellState, reading: CableReading, friction: float, dt: float, limits: SafetyLimits, *, is_homed: bool = True
) -> tuple[CellState, Finding | None]:
    """A cell whose tension T does not go with the motor's force R against winding in, or that says that a cable pushes.

    ``|T - R| <= cell_frictions * friction + cell_error + cell_part * max(|T|, |R|)`` and ``T >= -cell_error``: dry
    friction hides so much of a tension, and true friction may be more than is assumed. Besides, the winder must bring
    the tension to where the cell wants it with a loss that friction explains, as long as the drum is slow.

    Args:
        state: state after the period before.
        reading: the cable; one without a load cell is left alone.
        friction: assumed dry friction of the rotor at the drum [N].
        dt: period [s].
        limits: when it is a fault.
        is_homed: whether R is known; while drums are homed a pushing cable alone is looked for.
    """
    felt = reading.felt
    if felt is None:
        return state, None
    allowed = _compute_allowed(felt, reading.resistance, friction, limits)
    is_pushing = felt < -limits.cell_error
    is_apart = is_pushing or (is_homed and abs(felt - reading.resistance) > allowed)
    state = CellState(
        apart=state.apart + dt if is_apart else 0.0, beyond=state.beyond + dt if reading.is_loss_most else 0.0
    )
    told = f"its load cell tells {felt:.1f} N"
    if state.apart >= limits.cell_time:
        if is_pushing:
            return state, Finding(FaultKind.LOAD_CELL, f"{told}; allowed: at least {-limits.cell_error:g} N")
        text = f"{told}, its motor {reading.resistance:.1f} N with friction; allowed: {allowed:.1f} N apart"
        return state, Finding(FaultKind.LOAD_CELL, text)
    if state.beyond >= limits.cell_beyond:
        text = f"{told}, its motor {reading.resistance:.1f} N, and the slow drum's friction explains no such difference"
        return state, Finding(FaultKind.LOAD_CELL, f"{text}; allowed: for {limits.cell_beyond:g} s")
    return state, None


def _compute_allowed(felt: float, resistance: float, friction: float, limits: SafetyLimits) -> float:
    """Largest difference of a cell's tension and the motor's force [N]."""
    return limits.cell_frictions * friction + limits.cell_error + limits.cell_part * max(abs(felt), abs(resistance))


@explain_fields
@final
@dataclass(frozen=True, kw_only=True, slots=True)
class ClaimState:
    """What a load cell's claim that its cable is slack is compared with."""

    pull: float = math.nan
    """Cable wound in when the cell told of a load, or the lengths of slack, for the last time [m]; NaN at first."""
    excess: float = 0.0
    """Excess of the lengths when the cell told of a load for the last time [m]."""
    elapsed: float = 0.0
    """Time since ``pull`` was set [s]."""


def watch_claim(
    state: ClaimState,
    reading: CableReading,
    allowed: CableRange,
    dt: float,
    limits: SafetyLimits,
    *,
    excess: float,
    is_slack: bool,
    is_judged: bool,
) -> tuple[ClaimState, Finding | None]:
    """A cell that says that its cable is slack, while the drum bends the trunk by winding it in.

    A slack cable lowers the excess of the lengths by its slack, whatever the trunk does. The claim is untrue where the
    drum winds in `cell_bent` while the lengths tell of at most `cell_loosened` of slack for `cell_beyond`, so that the
    trunk is bent by it, and the motor feels more than its dry friction. The tension at which a cell and its motor
    disagree in `watch_cell` comes late or never then, for the trunk yields.

    Args:
        state: state after the period before.
        reading: the cable; one without a load cell is left alone.
        allowed: what the cable may do.
        dt: period [s].
        limits: when it is a fault.
        excess: excess of the cable, of lengths without their elastic part [m].
        is_slack: whether the cell says that the cable carries no load.
        is_judged: whether all other cables carry load; lengths tell nothing of one cable where two are slack.
    """
    felt = reading.felt
    if felt is None or not is_slack:
        return ClaimState(pull=reading.pull, excess=excess), None
    if excess < state.excess - limits.cell_loosened:
        return ClaimState(pull=reading.pull, excess=state.excess), None
    state = replace(state, elapsed=state.elapsed + dt)
    wound = reading.pull - state.pull
    is_light = reading.resistance <= allowed.friction + limits.cell_error
    if not (wound >= limits.cell_bent and state.elapsed >= limits.cell_beyond and is_judged) or is_light:
        return state, None
    text = f"its load cell tells {felt:.1f} N while {1e3 * wound:.1f} mm of its cable bent the trunk"
    return state, Finding(FaultKind.LOAD_CELL, f"{text}; allowed: {1e3 * limits.cell_bent:g} mm")


def find_untrue_zero(felt: float | None, friction: float, limits: SafetyLimits) -> str:
    """Why a cell must not be used when no torque is on: friction alone holds its cable then; "" where it may."""
    if felt is None:
        return ""
    allowed = _compute_allowed(felt, 0.0, friction, limits)
    if -limits.cell_error <= felt <= allowed:
        return ""
    span = f"{-limits.cell_error:g} to {allowed:.1f} N"
    return f"its load cell tells {felt:.1f} N without torque; allowed: {span}; measure its zero and its sense"
