"""Texts of the robot's tab: state, next step, cables and faults, as HTML that is readable on light and dark."""

from __future__ import annotations

import html
import math

from spiraltrunk.hardware.safety.fault import Fault, FaultKind
from spiraltrunk.hardware.safety.states import Mode
from spiraltrunk.report.style import COLORS
from spiraltrunk.workflows.drive.recorder import REACTION
from spiraltrunk.workflows.drive.remote.state import RobotState

_BADGES = {
    "not connected": ("#6b6b6b", "white"), "connecting": ("#6b6b6b", "white"), "safe": ("#007a59", "white"),
    "homing": ("#1F4FA3", "white"), "letting go": ("#1F4FA3", "white"), "armed": ("#E69F00", "black"),
    "fault": ("#B84A00", "white"),
}  # fmt: skip
"""Colours of states, ground and letters: those of Okabe and Ito, darkened where white letters need it."""

_FIRST = "The twin is a simulation of the robot: connect it to try everything without hardware."

_STOPPED = "Clear the stop to go on."

CLEAR_FAULT = "I found the cause: clear the fault"
"""Label of the button that clears a fault."""

CLEAR_STOP = "Clear the stop"
"""Its label where a person's STOP is the only fault."""

_TITLES = ("cable", "pulled in [mm]", "goal [mm]", "tension [N]", "motor [&deg;C]")


def format_status(state: RobotState | None, *, robot: str, owner: str, is_mine: bool) -> str:
    """State, who is in control, and what to do next.

    Args:
        state: the robot's state; None before the first.
        robot: what it is called; empty where none is connected.
        owner: page in control; empty where none is.
        is_mine: whether this page is.
    """
    name = find_mode(state, robot)
    ground, letters = _BADGES[name]
    badge = (
        f'<span style="background:{ground};color:{letters};padding:2px 10px;border-radius:4px;font-weight:700">'
        f"{name.upper()}</span>"
    )
    head = f"{badge} &nbsp;{html.escape(robot)}" if robot else badge
    if state is not None:
        head += ", homed" if state.snapshot.is_homed else ", not homed"
    whose = "this page" if is_mine else html.escape(owner) or "nobody"
    control = f"In control: <b>{whose}</b>." if robot else ""
    return _wrap(f"{head}<br>{control} {_advise(state, name, owner=owner, is_mine=is_mine)}")


def find_mode(state: RobotState | None, robot: str) -> str:
    """State in one or two words."""
    if state is None:
        return "connecting" if robot else "not connected"
    return "letting go" if state.snapshot.is_letting_go else state.snapshot.mode.value


def _advise(state: RobotState | None, name: str, *, owner: str, is_mine: bool) -> str:
    """What to do next."""
    if state is None:
        return "Starting takes some seconds." if name == "connecting" else _FIRST
    if state.run:
        return "A strategy runs; STOP ends it."
    if not is_mine:
        return "Watch, and press STOP if need be." if owner else "Take control to move it."
    return {
        "safe": "No torque. " + ("Enable it to move." if state.snapshot.is_homed else "Home it first."),
        "homing": "Cables are wound in until they are taut.",
        "armed": "Torque is on. Keep this page in front.",
        "fault": "Torque is off. " + (_STOPPED if is_stop(state) else "Look for the cause, then clear it."),
    }.get(name, "")


def format_cables(state: RobotState) -> str:
    """Table of the cables.

    It has no ``thead``: the table is sent anew several times a second, and of each ``thead`` Chromium 156 keeps a media
    query for as long as the page is open.
    """
    head = "".join(
        f'<th style="text-align:right;font-weight:600;padding:0 0 2px 6px">{title}</th>' for title in _TITLES
    )
    rows = "".join(_format_row(state, i) for i in range(len(state.goals)))
    return _wrap(
        '<table style="width:100%;border-collapse:collapse;font-variant-numeric:tabular-nums">'
        f"<tbody><tr>{head}</tr>{rows}</tbody></table>{_format_loop(state)}"
    )


def _format_row(state: RobotState, i: int) -> str:
    cable, goal = state.snapshot.cables[i], state.goals[i]
    is_armed = state.snapshot.mode is Mode.ARMED
    cells = (
        f'<span style="color:{COLORS[i % len(COLORS)]}">&#9632;</span> {i + 1}',
        f"{round(1e3 * state.pulls[i], 1) + 0.0:.1f}" if state.snapshot.is_homed else "&ndash;",
        "&ndash;" if not is_armed else "follows" if goal is None else f"{1e3 * goal:.1f}",
        f"{cable.tension:.1f}" if is_armed else "&ndash;",
        "&ndash;" if math.isnan(cable.temperature) else f"{cable.temperature:.0f}",
    )
    return "<tr>" + "".join(f'<td style="text-align:right;padding:1px 0">{cell}</td>' for cell in cells) + "</tr>"


def _format_loop(state: RobotState) -> str:
    """How late the loop is, what feedback is lost, and when the page answered."""
    late = state.lateness
    page = "no page answers" if math.isinf(state.page_age) else f"page answered {1e3 * state.page_age:.0f} ms ago"
    clock = "twin behind the clock" if state.is_twin else "loop late"
    return (
        f'<div style="opacity:.8;margin-top:4px">{clock} by {1e3 * late.p50:.1f} ms (median), {1e3 * late.p99:.1f} ms '
        f"(99th&nbsp;percentile); {100 * state.snapshot.loss:.1f}&nbsp;% of feedback lost; {page}</div>"
    )


def format_faults(state: RobotState) -> str:
    """Faults with their times and the reaction, warnings, and what was done unasked; empty where there is nothing."""
    snapshot = state.snapshot
    lines = [_bar("#B84A00", _format_fault(fault, state.note)) for fault in snapshot.faults]
    if snapshot.faults:
        lines.append(f'<div style="opacity:.8;margin:2px 0 4px 10px">Reaction: {REACTION}.</div>')
    lines += [_bar("#E69F00", html.escape(warning)) for warning in snapshot.warnings]
    if state.note and not any(fault.kind is FaultKind.STOPPED for fault in snapshot.faults):
        lines.append(_bar("#0072B2", html.escape(state.note)))
    return _wrap("".join(lines)) if lines else ""


def _format_fault(fault: Fault, note: str) -> str:
    """Kind, time and text; a stop that no person asked for has its cause in the note."""
    kind, text = fault.kind.value, fault.text
    if fault.kind is FaultKind.STOPPED:
        kind, text = ("stopped", note) if note else (kind, "")
    where = "" if fault.cable is None else f", cable {fault.cable + 1}"
    reason = f": {html.escape(text)}" if text else ""
    return f"<b>{html.escape(kind)}{where}</b>, {fault.time:.2f} s{reason}"


def is_stop(state: RobotState) -> bool:
    """Whether a person's STOP is the only fault, so that there is no cause to look for."""
    faults = state.snapshot.faults
    return bool(faults) and not state.note and all(fault.kind is FaultKind.STOPPED for fault in faults)


def format_closed(state: RobotState, *, is_mine: bool) -> str:
    """What to do before a strategy can run."""
    mode = state.snapshot.mode
    if not is_mine:
        return _wrap("Take control to run a strategy.")
    return _wrap(
        {
            Mode.FAULT: f"Clear the {'stop' if is_stop(state) else 'fault'} to run a strategy.",
            Mode.ARMED: "Disable the robot to run a strategy: it gets a twin of its own.",
        }.get(mode, "Wait until the robot is safe.")
    )


def format_run(state: RobotState | None) -> str:
    """Phase or end of a strategy; empty before the first."""
    if state is None or not (state.run or state.result):
        return ""
    text = f"Running: <b>{html.escape(state.run)}</b>" if state.run else html.escape(state.result)
    return _wrap(text)


def _bar(color: str, text: str) -> str:
    return f'<div style="border-left:4px solid {color};padding:1px 0 1px 8px;margin-bottom:4px">{text}</div>'


def _wrap(text: str) -> str:
    return f'<div style="font-size:0.82em;line-height:1.45;padding:0 0.75em 0.4em">{text}</div>'
