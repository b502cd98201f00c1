"""Joint bench records in ``spiraltrunk calibrate``: static loads and ring-downs of single joints."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

from spiraltrunk.cli.arguments import read_number, read_text
from spiraltrunk.cli.output import DONE, Answer, UsageError, add_file_count, format_json, open_out, quote

if TYPE_CHECKING:
    from spiraltrunk.design import TrunkDesign
    from spiraltrunk.workflows.calibrate.joint_bench import Bench, RingDownFile

_PERCENT = 5.0
"""Default standard deviation of an inertia [%] (ours: from a drawing and a density)."""


def add_bench_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of joint bench records."""
    group = parser.add_argument_group("single joints on a bench, alone or as prior knowledge of a fit")
    group.add_argument(
        "--bench", type=read_text, metavar="FILE", help="static loads: CSV of joint,lever_arm_m,mass_g,angle_deg"
    )
    group.add_argument(
        "--ring-down", type=read_text, action="append", default=[], metavar="JOINT=FILE",
        help="ring-down of a joint: CSV of time_s,acceleration; reported and plotted, not used in the fit",
    )  # fmt: skip
    group.add_argument(
        "--inertia-kg-m2", type=read_text, action="append", default=[], metavar="JOINT=I",
        help="inertia about that joint of everything that swings; required for each ring-down",
    )  # fmt: skip
    group.add_argument(
        "--inertia-sd-percent", type=read_number, metavar="P",
        help=f"standard deviation of the inertias (default {_PERCENT:g})",
    )  # fmt: skip


def has_bench(arguments: argparse.Namespace) -> bool:
    """Whether joint bench records are given."""
    return arguments.bench is not None or bool(arguments.ring_down)


def fit_bench_records(arguments: argparse.Namespace, design: TrunkDesign) -> Bench:
    """Read and fit the records of a design's joints."""
    from spiraltrunk.workflows.calibrate.joint_bench import fit_bench

    return fit_bench(arguments.bench, read_ring_downs(arguments), design.n_joint)


def run_bench(arguments: argparse.Namespace, design: TrunkDesign) -> Answer:
    """Fit joint bench records without takes."""
    from spiraltrunk.workflows.calibrate.joint_bench import FILES, WRITER, compute_bench_result, write_bench_folder

    with open_out(arguments.out, WRITER, FILES) as output:
        bench = fit_bench_records(arguments, design)
        result = compute_bench_result(bench) if output is None else write_bench_folder(bench, output)
    return DONE, format_json(result) if arguments.json else add_file_count(format_bench(result), result, arguments)


def format_bench(result: dict[str, Any]) -> str:
    """Joints as tables."""
    tables = [_format_static(result["static"])] if result["static"] else []
    tables += [_format_ring_downs(result["ring_down"])] if result["ring_down"] else []
    return "\n\n".join(tables)


def _format_static(joints: list[dict[str, Any]]) -> str:
    from spiraltrunk.report import format_table

    header = ("joint", "beam law", "K", "first moment", "faces add", "from deg", "residual mN m")
    names = ("beam_law_nm_per_rad", "stiffness_nm_per_rad", "onset_nm", "faces_nm_per_rad", "faces_from_deg")
    rows = [
        (str(row["joint"]), *(_format_interval(row[name]) for name in names),
         f"{1e3 * row['beam_law_rms_nm']:.2f}, {1e3 * row['rms_nm']:.2f}")
        for row in joints
    ]  # fmt: skip
    title = "Static loads, N m/rad and N m with 95 % intervals; residual RMS of the beam law and of the full law"
    return format_table(rows, header=header, title=title, indent=2)


def _format_ring_downs(joints: list[dict[str, Any]]) -> str:
    from spiraltrunk.report import format_table

    header = ("joint", "Hz", "damping ratio", "K N m/rad", "damping N m s/rad")
    names = ("frequency_hz", "damping_ratio", "stiffness_nm_per_rad", "damping_nms_per_rad")
    rows = [(str(row["joint"]), *(_format_interval(row[name]) for name in names)) for row in joints]
    return format_table(rows, header=header, title="Ring-downs with 95 % intervals", indent=2)


def _format_interval(interval: dict[str, float | None]) -> str:
    value, low, high = interval["value"], interval["low_95"], interval["high_95"]
    if not value:
        return "-"
    return f"{value:.4g}" if low is None or high is None else f"{value:.4g} ({low:.3g} to {high:.3g})"


def read_ring_downs(arguments: argparse.Namespace) -> list[RingDownFile]:
    """Ring-down records with their inertias.

    Raises:
        UsageError: where a record has no inertia, or an inertia no record.
    """
    if not arguments.ring_down and (arguments.inertia_kg_m2 or arguments.inertia_sd_percent is not None):
        option = "--inertia-kg-m2" if arguments.inertia_kg_m2 else "--inertia-sd-percent"
        raise UsageError(f"{option} given without --ring-down; allowed: both")
    inertia: dict[int, float] = {}
    for text in arguments.inertia_kg_m2:
        joint, value = _split("--inertia-kg-m2", text, "JOINT=I")
        if joint in inertia:
            raise UsageError(f"--inertia-kg-m2 is given twice for joint {joint}; allowed: once")
        try:
            inertia[joint] = float(read_number(value))
        except argparse.ArgumentTypeError as error:
            raise UsageError(f"--inertia-kg-m2 {text}: {error}, above 0 kg m^2") from None
        if inertia[joint] <= 0:
            raise UsageError(f"--inertia-kg-m2 is {quote(text)}; allowed: above 0 kg m^2")
    percent = _PERCENT if arguments.inertia_sd_percent is None else arguments.inertia_sd_percent
    if percent < 0:
        raise UsageError(f"--inertia-sd-percent is {percent:g}; allowed: 0 or more")
    files = [_split("--ring-down", text, "JOINT=FILE") for text in arguments.ring_down]
    recorded = {joint for joint, _ in files}
    for joint in sorted(recorded - inertia.keys()):
        raise UsageError(f"no inertia for the ring-down of joint {joint}; allowed: --inertia-kg-m2 {joint}=I")
    for joint in sorted(inertia.keys() - recorded):
        raise UsageError(f"--inertia-kg-m2 of joint {joint} without its ring-down; allowed: --ring-down {joint}=FILE")
    if not files:
        return []
    from spiraltrunk.workflows.calibrate.joint_bench import RingDownFile

    return [
        RingDownFile(joint=joint, path=path, inertia=inertia[joint], inertia_spread=percent / 100 * inertia[joint])
        for joint, path in files
    ]


def _split(option: str, text: str, form: str) -> tuple[int, str]:
    name, equals, value = text.partition("=")
    if not (equals and value and name.isascii() and name.isdigit() and int(name[:9]) >= 1):
        raise UsageError(f"{option} is {quote(text)}; allowed: {form}, JOINT a whole number from 1")
    return int(name), value
