"""Bench records in ``spiraltrunk calibrate``: static loads and ring-downs of single joints."""

from __future__ import annotations

import argparse
import math
from typing import TYPE_CHECKING, Any

from spiraltrunk.cli.arguments import read_number, read_text
from spiraltrunk.cli.output import DONE, Answer, UsageError, format_json, quote

if TYPE_CHECKING:
    from spiraltrunk.workflows.calibrate.joint_bench import Bench, RingDownFile

_MOST_RINGS = 50
_MOST_JOINT = 199
_PERCENT = 5.0
"""Standard deviation of an inertia that is told without one [%] (ours: from a drawing and a density)."""


def add_bench_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of bench records."""
    group = parser.add_argument_group("single joints on a bench, alone or as what is known before the takes")
    group.add_argument(
        "--bench", type=read_text, metavar="FILE", help="static loads: CSV of joint,lever_arm_m,mass_g,angle_deg"
    )
    group.add_argument(
        "--ring-down", type=read_text, action="append", default=[], metavar="JOINT=FILE",
        help="a joint that rings down: CSV of time_s,acceleration; told and drawn, but not used for the takes",
    )  # fmt: skip
    group.add_argument(
        "--inertia-kg-m2", type=read_text, action="append", default=[], metavar="JOINT=I",
        help="inertia of all that swings about that joint; each ring-down needs it",
    )  # fmt: skip
    group.add_argument(
        "--inertia-sd-percent", type=read_number, metavar="P",
        help=f"standard deviation of the inertias (default {_PERCENT:g})",
    )  # fmt: skip


def has_bench(arguments: argparse.Namespace) -> bool:
    """Whether bench records are given."""
    return arguments.bench is not None or bool(arguments.ring_down)


def check_bench(arguments: argparse.Namespace) -> None:
    """Refuse options of the bench that do not go together, before any work is done.

    Raises:
        UsageError: names the option.
    """
    if len(arguments.ring_down) > _MOST_RINGS:
        raise UsageError(f"{len(arguments.ring_down)} ring-downs given; allowed: at most {_MOST_RINGS}")
    percent = arguments.inertia_sd_percent
    if percent is not None and not 0.0 <= percent < 100.0:
        raise UsageError(f"--inertia-sd-percent is {percent.text}; allowed: 0 to below 100")
    if not arguments.ring_down and (arguments.inertia_kg_m2 or percent is not None):
        option = "--inertia-kg-m2" if arguments.inertia_kg_m2 else "--inertia-sd-percent"
        raise UsageError(f"{option} given without --ring-down; allowed: both")
    _read_rings(arguments)


def fit_bench_records(arguments: argparse.Namespace) -> Bench:
    """Read and fit the records that are given."""
    from spiraltrunk.workflows.calibrate.joint_bench import fit_bench

    return fit_bench(arguments.bench, _read_rings(arguments))


def run_bench(arguments: argparse.Namespace) -> Answer:
    """Bench records alone."""
    from spiraltrunk.workflows.calibrate.joint_bench import compute_bench_result, write_bench_folder

    bench = fit_bench_records(arguments)
    result = compute_bench_result(bench) if arguments.out is None else write_bench_folder(bench, arguments.out)
    if arguments.json:
        return DONE, format_json(result)
    text = format_bench(result)
    return DONE, text if arguments.out is None else f"{text}\n\n{len(result['files'])} files in {arguments.out}"


def format_bench(result: dict[str, Any]) -> str:
    """Joints as tables."""
    parts = []
    if result["static"]:
        parts.append(_format_static(result["static"]))
    if result["ring_down"]:
        parts.append(_format_rings(result["ring_down"]))
    return "\n\n".join(parts)


def _format_static(joints: list[dict[str, Any]]) -> str:
    from spiraltrunk.report import format_table

    header = ("joint", "beam law", "K", "first moment", "faces add", "from deg", "left mN m")
    names = ("beam_law_nm_per_rad", "stiffness_nm_per_rad", "onset_nm", "faces_nm_per_rad", "faces_from_deg")
    rows = [
        (
            str(row["joint"]), *(_say(row[name]) for name in names),
            f"{1e3 * row['beam_law_rms_nm']:.2f}, {1e3 * row['rms_nm']:.2f}",
        )
        for row in joints
    ]  # fmt: skip
    title = "Static loads, N m/rad and N m with 95 % intervals; left by the beam law, by the law"
    return format_table(rows, header=header, title=title, indent=2)


def _format_rings(joints: list[dict[str, Any]]) -> str:
    from spiraltrunk.report import format_table

    header = ("joint", "Hz", "damping ratio", "K N m/rad", "damping N m s/rad")
    names = ("frequency_hz", "damping_ratio", "stiffness_nm_per_rad", "damping_nms_per_rad")
    rows = [(str(row["joint"]), *(_say(row[name]) for name in names)) for row in joints]
    return format_table(rows, header=header, title="Ring-downs with 95 % intervals", indent=2)


def _say(interval: dict[str, float | None]) -> str:
    value, low, high = interval["value"], interval["low_95"], interval["high_95"]
    if value is None or value == 0.0:
        return "-"
    return f"{value:.4g}" if low is None or high is None else f"{value:.4g} ({low:.3g} to {high:.3g})"


def _read_rings(arguments: argparse.Namespace) -> list[RingDownFile]:
    from spiraltrunk.workflows.calibrate.joint_bench import RingDownFile

    inertia: dict[int, float] = {}
    for text in arguments.inertia_kg_m2:
        joint, value = _split("--inertia-kg-m2", text, "JOINT=I")
        if joint in inertia:
            raise UsageError(f"--inertia-kg-m2 is given twice for joint {joint}; allowed: once")
        inertia[joint] = _read_inertia(text, value)
    percent = _PERCENT if arguments.inertia_sd_percent is None else float(arguments.inertia_sd_percent)
    rings = []
    for text in arguments.ring_down:
        joint, path = _split("--ring-down", text, "JOINT=FILE")
        if joint not in inertia:
            raise UsageError(f"no inertia for the ring-down of joint {joint}; allowed: --inertia-kg-m2 {joint}=I")
        spread = inertia[joint] * percent / 100
        rings.append(RingDownFile(joint=joint, path=path, inertia=inertia[joint], inertia_spread=spread))
    idle = set(inertia) - {ring.joint for ring in rings}
    if idle:
        joint = min(idle)
        raise UsageError(f"--inertia-kg-m2 of joint {joint} without its ring-down; allowed: --ring-down {joint}=FILE")
    return rings


def _split(option: str, text: str, form: str) -> tuple[int, str]:
    name, equals, value = text.partition("=")
    if not (equals and value and name.isascii() and name.isdigit() and 1 <= int(name[:9]) <= _MOST_JOINT):
        raise UsageError(f"{option} is {quote(text)}; allowed: {form}, JOINT a whole number from 1")
    return int(name), value


def _read_inertia(text: str, value: str) -> float:
    try:
        number = float(value) if value.isascii() and "_" not in value else math.nan
    except ValueError:
        number = math.nan
    if not 0.0 < number < 1e3:
        raise UsageError(f"--inertia-kg-m2 is {quote(text)}; allowed: above 0, below 1000 kg m^2")
    return number
