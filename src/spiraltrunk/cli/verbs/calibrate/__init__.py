"""``spiraltrunk calibrate``: stiffness, mass, friction, slack and holes of one trunk from its recordings."""

from __future__ import annotations

import argparse
import sys
from typing import TYPE_CHECKING, Any

from spiraltrunk.cli.arguments import add_parser, read_number, read_seed, read_text
from spiraltrunk.cli.output import DONE, Answer, UsageError, add_file_count, complain, format_json, open_out
from spiraltrunk.cli.progress import show_progress
from spiraltrunk.cli.verbs.calibrate import joint_bench

if TYPE_CHECKING:
    from spiraltrunk.calibration.calibrate import Settings, Weighing
    from spiraltrunk.design import TrunkDesign
    from spiraltrunk.workflows.calibrate.joint_bench import Bench


def add_verb(verbs: Any) -> None:
    """Add the verb and its arguments."""
    parser = add_parser(
        verbs, "calibrate", _run, "fit a trunk's parameters to recordings, with the error on other takes"
    )
    parser.add_argument(
        "takes", type=read_text, nargs="*", metavar="TAKE",
        help="a recording as RUN=FILE, or a file whose name begins with the run's; without --hold-out the last take of "
        "every run with several takes is held out",
    )  # fmt: skip
    parser.add_argument(
        "--hold-out", type=read_text, action="append", default=[], metavar="TAKE",
        help="a recording to evaluate the fit on; it is not fitted, though it be among the TAKEs; can be repeated",
    )  # fmt: skip
    parser.add_argument("--protocol", type=read_text, default="paper", metavar="FILE", help="protocol, a TOML file")
    parser.add_argument(
        "--axes", type=read_text, metavar="NAME", help="axis convention of the recordings, as in validate"
    )
    parser.add_argument(
        "--design", type=read_text, metavar="DESIGN", help="preset or TOML file (default: the protocol's)"
    )
    parser.add_argument(
        "--mass-g", type=read_number, metavar="M", help="weighed mass of all sections with the gripper, no housing"
    )
    parser.add_argument(
        "--mass-sd-g", type=read_number, metavar="S", help="its standard deviation (default: 1 percent)"
    )
    parser.add_argument(
        "--virtual", type=read_text, metavar="DIR",
        help="instead of a fit: simulate the protocol on a trunk that deviates from its design, and write synthetic "
        "takes there",
    )  # fmt: skip
    parser.add_argument("--seed", type=read_seed, help="seed of the simulated trunk (default 0)")
    parser.add_argument("--out", type=read_text, metavar="DIR", help="write the new design and the figures there")
    joint_bench.add_bench_arguments(parser)


def _run(arguments: argparse.Namespace) -> Answer:
    _check(arguments)
    from spiraltrunk.design import load_design
    from spiraltrunk.mocap.protocol.toml import load_protocol

    protocol = load_protocol(arguments.protocol)
    design = load_design(arguments.design or protocol.design)
    if joint_bench.has_bench(arguments) and not arguments.takes:
        return joint_bench.run_bench(arguments, design)
    if arguments.virtual is not None:
        return _simulate(arguments, design, protocol)
    return _fit(arguments, design, protocol)


def _check(arguments: argparse.Namespace) -> None:
    """Refuse arguments that cannot be combined, before any work is done."""
    is_virtual, has_takes = arguments.virtual is not None, bool(arguments.takes)
    has_bench = joint_bench.has_bench(arguments)
    modes = "one TAKE or more, --bench FILE or --ring-down alone or with takes, or --virtual DIR alone"
    rules = {
        f"takes given with --virtual; allowed: {modes}": is_virtual and has_takes,
        f"bench records given with --virtual; allowed: {modes}": is_virtual and has_bench,
        "--out given with --virtual; allowed: --virtual DIR alone, which is written to":
            is_virtual and arguments.out is not None,
        "--seed given without --virtual; allowed: both, as nothing else is random":
            arguments.seed is not None and not is_virtual,
        f"no take given; allowed: {modes}": not (has_takes or is_virtual or has_bench),
        "--hold-out given without takes; allowed: with one TAKE or more": arguments.hold_out and not has_takes,
        "--mass-g given without takes; allowed: with one TAKE or more": arguments.mass_g is not None and not has_takes,
        "--axes given without takes; allowed: with one TAKE or more": arguments.axes is not None and not has_takes,
        "--mass-sd-g given without --mass-g; allowed: both, or --mass-g alone":
            arguments.mass_sd_g is not None and arguments.mass_g is None,
    }  # fmt: skip
    for message, applies in rules.items():
        if applies:
            raise UsageError(message)
    joint_bench.read_ring_downs(arguments)


def _read_settings(arguments: argparse.Namespace, bench: Bench | None) -> Settings:
    from spiraltrunk.calibration.calibrate import Settings
    from spiraltrunk.workflows.calibrate.joint_bench import compute_prior

    joints = () if bench is None else compute_prior(bench)
    if arguments.mass_g is None:
        return Settings(bench=joints)
    return Settings(weighing=_read_weighing(arguments), bench=joints)


def _read_weighing(arguments: argparse.Namespace) -> Weighing:
    """The weighing; errors have the option and the grams that were typed."""
    from spiraltrunk.calibration.calibrate import Weighing
    from spiraltrunk.design.schema import MILLI, convert_error
    from spiraltrunk.errors import DesignError

    mass = 1e-3 * float(arguments.mass_g)
    spread = 0.01 * mass if arguments.mass_sd_g is None else 1e-3 * float(arguments.mass_sd_g)
    try:
        return Weighing(mass=mass, spread=spread)
    except DesignError as error:
        is_mass = error.name == "weighing.mass"
        option, typed = ("--mass-g", arguments.mass_g) if is_mass else ("--mass-sd-g", arguments.mass_sd_g)
        raise convert_error(error, option, MILLI, typed) from None


def _simulate(arguments: argparse.Namespace, design: TrunkDesign, protocol: Any) -> Answer:
    from spiraltrunk.workflows.virtual_session.cameras import NAME, select_sections
    from spiraltrunk.workflows.virtual_session.printed_trunk import draw_printed_trunk
    from spiraltrunk.workflows.virtual_session.session import WRITER, list_files, simulate_session, write_session

    select_sections(design)  # Refuses before the simulation, which takes minutes.
    seed = arguments.seed or 0
    trunk = draw_printed_trunk(design, seed)
    names = list_files(design, protocol.runs)
    with open_out(arguments.virtual, WRITER, names, "--virtual") as output, show_progress(sys.stderr) as progress:
        runs = simulate_session(design, trunk, protocol, progress=progress)
        progress("writing", 0, 1)
        files = [path.name for path in write_session(design, runs, seed, output or arguments.virtual)]
    mass_g = 1e3 * float(trunk.design.section_mass.sum())
    if not arguments.json:
        return DONE, f"{NAME}: {len(files)} files in {arguments.virtual}, axes y-up, the trunk weighs {mass_g:.1f} g"
    result = {
        "what": NAME, "seed": seed, "design": design.name, "axes": "y-up", "mass_g": mass_g,
        "friction": trunk.design.cable.friction, "stiffness_nm_per_rad": trunk.design.joint_stiffness,
        "slack_mm": 1e3 * trunk.winders.slack, "center_fraction": trunk.design.mass.center_fraction,
        "hole_fraction": trunk.design.cable.hole_fraction, "give_mm_per_n": 1e3 * trunk.winders.compliance,
        "files": files,
    }  # fmt: skip
    return DONE, format_json(result)


def _fit(arguments: argparse.Namespace, design: TrunkDesign, protocol: Any) -> Answer:
    from spiraltrunk.mocap.protocol.protocol import sort_takes
    from spiraltrunk.workflows.calibrate.artifacts import (
        WRITER,
        compute_result,
        list_artifacts,
        run_calibration,
        write_calibration_folder,
    )
    from spiraltrunk.workflows.calibrate.recordings import Recordings, leave_out, split_takes

    given, held_out = sort_takes(protocol, arguments.takes), sort_takes(protocol, arguments.hold_out)
    fitted, held_out = (leave_out(given, held_out), held_out) if held_out else split_takes(given)
    recordings = Recordings(protocol=protocol, design=design, fitted=fitted, held_out=held_out, axes=arguments.axes)
    bench = joint_bench.fit_bench_records(arguments, design) if joint_bench.has_bench(arguments) else None
    settings = _read_settings(arguments, bench)
    names = list_artifacts(bench)
    with open_out(arguments.out, WRITER, names) as output, show_progress(sys.stderr) as progress:
        run = run_calibration(recordings, settings, bench, progress=progress)
        progress("report", 0, 1)
        result = compute_result(run) if output is None else write_calibration_folder(run, output)
    for note in (*result["notes"], *result["odd_in_recordings"]):
        complain(f"note: {note}", DONE)
    return DONE, format_json(result) if arguments.json else add_file_count(_format(result), result, arguments)


def _format(result: dict[str, Any]) -> str:
    """Parameters and errors as tables."""
    from spiraltrunk.report import format_table

    rows = [
        (name, *(f"{p[key]:.4g}" for key in ("before", "value", "low_95", "high_95")), p["unit"],
         "" if p["is_told"] else "not determined")
        for name, p in result["parameters"].items()
    ]  # fmt: skip
    header = ("parameter", "before", "fitted", "low", "high", "unit", "")
    parts = [format_table(rows, header=header, title="Parameters with 95 % intervals", indent=2)]
    parts += [_format_errors(result[part], part.replace("_", " ")) for part in ("held_out", "fitted") if result[part]]
    parts.append(_format_misfits(result["misfit_by_run"]))
    if result["bench"] is not None:
        parts.append(joint_bench.format_bench(result["bench"]))
    if result["to_record"]:
        parts.append("\n".join(["To determine the others:", *(f"  {words}" for words in result["to_record"])]))
    return "\n\n".join(parts)


def _format_misfits(misfits: list[dict[str, Any]]) -> str:
    from spiraltrunk.report import format_table

    rows = [
        (row["take"], str(row["shapes"]), f"{1e3 * row['rms_m']:.2f}", f"{1e3 * row['registered_rms_m']:.2f}",
         f"{1e3 * row['discrepancy_at_tip_m']:.1f}", "out of proportion" if row["is_out_of_proportion"] else "")
        for row in misfits
    ]  # fmt: skip
    header = ("takes", "shapes", "RMS", "registered", "discrepancy at tip", "")
    return format_table(rows, header=header, title="Misfit of the fitted runs in mm", indent=2)


def _format_errors(errors: dict[str, Any], words: str) -> str:
    from spiraltrunk.report import format_table
    from spiraltrunk.workflows.calibrate.artifacts import MODELS

    rows = []
    for name, row in errors.items():
        values = (row[f"{model}_mean_rmse_m"] for model in MODELS)
        rows.append((name, str(row["shapes"]), *("-" if v is None else f"{1e3 * v:.2f}" for v in values)))
    header = ("shapes", "number", "calibrated", "as designed", "paper's model")
    return format_table(rows, header=header, title=f"Mean RMSE in mm, {words}", indent=2)
