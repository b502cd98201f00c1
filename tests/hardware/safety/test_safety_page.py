"""SAFETY.md has a row for every fault, and its numbers are those of the code."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from spiraltrunk.hardware.motors.gm6020 import GM6020
from spiraltrunk.hardware.motors.load_cell import LoadCellSettings
from spiraltrunk.hardware.motors.sts.models import MODELS
from spiraltrunk.hardware.safety import probe, reaction, watchdog
from spiraltrunk.hardware.safety.fault import FaultKind
from spiraltrunk.hardware.safety.limits import SafetyLimits
from spiraltrunk.hardware.safety.states import Mode
from spiraltrunk.hardware.safety.watches import feedback_watch
from spiraltrunk.hardware.winder.homing import FLOORS, JAM_TIME

PAGE = (Path(__file__).parents[3] / "SAFETY.md").read_text()
ROWS: dict[str, str] = {}
for _line in PAGE.splitlines():
    if _line.startswith("| "):
        ROWS.setdefault(_line.split("|")[1].strip(), _line)
AGE_MAX = LoadCellSettings.__dataclass_fields__["age_max"].default
LIMITS, STS = SafetyLimits(), MODELS["sts3215-12v"].data_sheet


@pytest.mark.parametrize("kind", FaultKind)
def test_every_fault_has_a_row_with_what_a_person_does(kind: FaultKind) -> None:
    assert len([cell for cell in ROWS[kind.value].split("|") if cell.strip()]) == 3


@pytest.mark.parametrize("kind", FaultKind)
def test_a_row_says_homes_where_the_driver_asks_for_it(kind: FaultKind) -> None:
    cells = [cell for cell in ROWS[kind.value].split("|") if cell.strip()]
    assert kind.needs_homing == (re.search(r"\bhomes\b", cells[-1]) is not None)


@pytest.mark.parametrize("mode", Mode)
def test_every_state_has_a_row(mode: Mode) -> None:
    assert mode.value in ROWS


@pytest.mark.parametrize(
    ("kind", "said"),
    [
        (FaultKind.BAD_COMMAND, f"{1e3 * LIMITS.command_age:g} ms"),
        (FaultKind.STALE_COMMAND, f"{1e3 * LIMITS.command_age:g} ms"),
        (FaultKind.STALE_FEEDBACK, f"{1e3 * LIMITS.feedback_age:g} ms"),
        (FaultKind.STALE_FEEDBACK, f"{LIMITS.missed_cycles} periods"),
        (FaultKind.STALE_FEEDBACK, f"{LIMITS.loss_stopped:.0%}".replace("%", " %")),
        (FaultKind.STALE_FEEDBACK, f"warned of from {80 * LIMITS.loss_warned:g} %"),
        (FaultKind.FROZEN_FEEDBACK, f"{LIMITS.frozen_frames} equal"),
        (FaultKind.FROZEN_FEEDBACK, f"{LIMITS.frozen_torque:g} N m"),
        (FaultKind.FROZEN_FEEDBACK, f"{LIMITS.frozen_still} under whatever torque"),
        (FaultKind.IMPLAUSIBLE_FEEDBACK, f"{1e3 * LIMITS.speed_window:g} ms"),
        (FaultKind.COUNT_LOST, f"{1e3 * GM6020.silence_max:.0f} ms"),
        (FaultKind.OVER_TEMPERATURE, f"at {GM6020.temperature_stop:g} degC (STS: {STS.temperature_stop:g})"),
        (FaultKind.OVER_TEMPERATURE, f"from {GM6020.temperature_derate:g} (STS: {STS.temperature_derate:g})"),
        (FaultKind.VOLTAGE, f"{LIMITS.voltage_time:g} s"),
        (FaultKind.VOLTAGE, f"{LIMITS.voltage_least:g} to {LIMITS.voltage_most:g} V"),
        (FaultKind.STALL, f"{LIMITS.stall_time:g} s at {100 * LIMITS.stall_part:g} %"),
        (FaultKind.STALL, f"{LIMITS.blocked_time:g} s while its torque changes by {LIMITS.blocked_torque:g} N m"),
        (
            FaultKind.STALL,
            f"moved by up to {1e3 * LIMITS.blocked_motion_most:g} mm within about {LIMITS.blocked_memory:g} s",
        ),
        (
            FaultKind.STALL,
            f"{1e3 * LIMITS.untaken_length:g} mm of slack that no drum takes in for {LIMITS.stall_time:g} s",
        ),
        (FaultKind.SLACK, f"{1e3 * LIMITS.slack_time:g} ms without load, and {1e3 * LIMITS.step_length:g} mm"),
        (FaultKind.CABLE_SLIP, f"{1e3 * LIMITS.slip_length:g} mm wound in"),
        (FaultKind.CABLE_SLIP, f"at least {LIMITS.slip_tension:g} N"),
        (
            FaultKind.CABLE_LENGTHS,
            f"about {LIMITS.settle_time:g} s, {1e3 * LIMITS.step_length:g} mm more than any bend",
        ),
        (FaultKind.TANGLED_DRUM, f"{LIMITS.tangle_tension:g} N while {1e3 * LIMITS.tangle_length:g} mm"),
        (FaultKind.OVER_TENSION, f"{100 * LIMITS.over_part:g} % beyond for {1e3 * LIMITS.over_time:g} ms"),
        (FaultKind.OVER_TENSION, f"{100 * LIMITS.over_part_at_once:g} % at once"),
        (FaultKind.LENGTH_LIMIT, f"{1e3 * LIMITS.length_margin:g} mm"),
        (FaultKind.LOAD_CELL, f"{1e3 * AGE_MAX:g} ms"),
        (FaultKind.LOAD_CELL, f"the same number for {LIMITS.cell_still:g} s"),
        (FaultKind.LOAD_CELL, f"below {-LIMITS.cell_error:g} N"),
        (
            FaultKind.LOAD_CELL,
            f"{LIMITS.cell_frictions:g} times the dry friction, {LIMITS.cell_error:g} N and a quarter of the larger",
        ),
        (FaultKind.LOAD_CELL, f"for {LIMITS.cell_time:g} s"),
        (FaultKind.LOAD_CELL, f"for {LIMITS.cell_beyond:g} s"),
        (FaultKind.HOMING, f"{JAM_TIME:g} s"),
        (FaultKind.ARM, f"{1e3 * LIMITS.feedback_age:g} ms"),
        (FaultKind.WATCHDOG, f"{1e3 * watchdog.ANSWER_AGE:g} ms"),
    ],
)
def test_a_row_says_the_numbers_of_the_code(kind: FaultKind, said: str) -> None:
    assert said in ROWS[kind.value]


def test_ramps_and_times_are_those_of_the_code() -> None:
    assert f"a ramp of {reaction.LET_GO_TIME:g} s" in ROWS[Mode.ARMED.value]
    assert f"a ramp of {1e3 * reaction.RAMP_TIME:g} ms" in ROWS[Mode.FAULT.value]
    assert f"{probe.TORQUE:g} N m" in ROWS[Mode.HOMING.value]
    assert {3.0: "three times the floor"}[FLOORS] in ROWS[Mode.HOMING.value]
    assert f"{1e3 * watchdog.TIMEOUT:g} ms after the last heartbeat" in PAGE
    assert f"to zero within {1e3 * watchdog.RELEASE:g} ms" in PAGE


def test_the_noise_of_a_motor_at_rest_is_that_of_the_code() -> None:
    assert {0.5: "half"}[feedback_watch.LEAST_CHANGED] + f" of {feedback_watch.LEAST_FRAMES} or more frames" in PAGE


def test_the_length_beyond_every_bend_is_that_of_the_code() -> None:
    assert f"{1e3 * LIMITS.step_length:g} mm more do not" in PAGE
    assert (
        f"{1e3 * (LIMITS.step_length + 20 * LIMITS.compliance):g} mm while the sum of the tensions changes by 20 N"
        in PAGE
    )
