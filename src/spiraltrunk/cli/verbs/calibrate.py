"""``spiraltrunk calibrate``: stiffness, mass, friction, slack and holes of one trunk from its recordings."""

from __future__ import annotations

import argparse
import sys
from typing import TYPE_CHECKING, Any

from spiraltrunk.cli.arguments import Typed, add_parser, read_number, read_seed, read_text
from spiraltrunk.cli.output import DONE, Answer, UsageError, check_folder, complain, format_json
from spiraltrunk.cli.progress import show_progress
from spiraltrunk.cli.verbs import calibrate_bench

if TYPE_CHECKING:
    from spiraltrunk.calibration.calibrate import Settings
    from spiraltrunk.design import TrunkDesign
    from spiraltrunk.workflows.calibrate.joint_bench import Bench
    from spiraltrunk.workflows.calibrate.recordings import Recordings

_MOST_TAKES = 200


def add_verb(verbs: Any) -> None:
    """Add the verb and its arguments."""
    parser = add_parser(verbs, "calibrate", _run, "fit of the trunk's parameters to recordings, with held-out error")
    parser.add_argument(
        "takes", type=read_text, nargs="*", metavar="TAKE",
        help="a recording as RUN=FILE, or a file whose name begins with the run's; with no --hold-out the last take "
        "of every run that has several is held out",
    )  # fmt: skip
    parser.add_argument(
        "--hold-out", type=read_text, action="append", default=[], metavar="TAKE",
        help="a recording that is not fitted but judged on; may be given often",
    )  # fmt: skip
    parser.add_argument(
        "--protocol", type=read_text, default="paper", metavar="FILE", help="what was done, a TOML file"
    )
    parser.add_argument(
        "--axes", type=read_text, metavar="NAME", help="axis convention of the recordings, as in validate"
    )
    parser.add_argument("--design", type=read_text, metavar="DESIGN", help="a preset or TOML file (the protocol's)")
    parser.add_argument(
        "--mass-g", type=read_number, metavar="M", help="weighed mass of all sections with the gripper, no housing"
    )
    parser.add_argument(
        "--mass-sd-g", type=read_number, metavar="S", help="standard deviation of that (default: 1 percent)"
    )
    parser.add_argument(
        "--virtual", type=read_text, metavar="DIR",
        help="no takes: play the protocol on a simulated trunk off its design and write takes there, no measurement",
    )  # fmt: skip
    parser.add_argument("--seed", type=read_seed, help="what the virtual trunk is drawn from (default 0)")
    parser.add_argument("--out", type=read_text, metavar="DIR", help="write the new design and the figures there")
    calibrate_bench.add_bench_arguments(parser)


def _run(arguments: argparse.Namespace) -> Answer:
    _check(arguments)
    if calibrate_bench.has_bench(arguments) and not arguments.takes:
        return calibrate_bench.run_bench(arguments)
    from spiraltrunk.design import load_design
    from spiraltrunk.mocap.protocol.toml import load_protocol

    protocol = load_protocol(arguments.protocol)
    design = load_design(arguments.design or protocol.design)
    if arguments.virtual is not None:
        return _play(arguments, design, protocol)
    from spiraltrunk.mocap.protocol.protocol import sort_takes
    from spiraltrunk.workflows.calibrate.recordings import Recordings, split_takes

    given = sort_takes(protocol, arguments.takes)
    fitted, held_out = (given, sort_takes(protocol, arguments.hold_out)) if arguments.hold_out else split_takes(given)
    recordings = Recordings(protocol=protocol, design=design, fitted=fitted, held_out=held_out, axes=arguments.axes)
    bench = calibrate_bench.fit_bench_records(arguments) if calibrate_bench.has_bench(arguments) else None
    return _fit(arguments, recordings, bench)


def _check(arguments: argparse.Namespace) -> None:
    """Refuse arguments that do not go together, before any work is done."""
    _check_kind(arguments)
    if len(arguments.takes) + len(arguments.hold_out) > _MOST_TAKES:
        raise UsageError(f"{len(arguments.takes)} takes given; allowed: at most {_MOST_TAKES}")
    both = set(arguments.takes) & set(arguments.hold_out)
    if both:
        raise UsageError(f"{sorted(both)[0]!r} is fitted and held out; allowed: one of them")
    if arguments.mass_sd_g is not None and arguments.mass_g is None:
        raise UsageError("--mass-sd-g given without --mass-g; allowed: both, or --mass-g alone")
    for option, value in (("--mass-g", arguments.mass_g), ("--mass-sd-g", arguments.mass_sd_g)):
        _check_positive(option, value)
    for option, folder in (("--out", arguments.out), ("--virtual", arguments.virtual)):
        if folder is not None:
            check_folder(folder, option)


def _check_kind(arguments: argparse.Namespace) -> None:
    """Refuse what is not exactly one of takes with or without a bench, a bench alone, a virtual capture alone."""
    is_virtual, has_bench = arguments.virtual is not None, calibrate_bench.has_bench(arguments)
    of_takes = {
        "--hold-out": bool(arguments.hold_out), "--mass-g": arguments.mass_g is not None,
        "--axes": arguments.axes is not None,
    }  # fmt: skip
    allowed = "one TAKE or more, --bench FILE or --ring-down alone or with takes, or --virtual DIR alone"
    if is_virtual and (arguments.takes or has_bench):
        raise UsageError(f"{'takes' if arguments.takes else 'bench records'} given with --virtual; allowed: {allowed}")
    if is_virtual and arguments.out is not None:
        raise UsageError("--out given with --virtual; allowed: --virtual DIR alone, which is written to")
    if not is_virtual and arguments.seed is not None:
        raise UsageError("--seed given without --virtual; allowed: both, as nothing else is drawn")
    if not arguments.takes and not is_virtual and not has_bench:
        raise UsageError(f"no take given; allowed: {allowed}")
    for option, is_given in of_takes.items():
        if is_given and not arguments.takes:
            raise UsageError(f"{option} given without takes; allowed: with one TAKE or more")
    calibrate_bench.check_bench(arguments)


def _check_positive(option: str, value: Typed | None) -> None:
    if value is not None and not 0.0 < value < 1e6:
        raise UsageError(f"{option} is {value.text}; allowed: above 0, below 1000000 g")


def _read_settings(arguments: argparse.Namespace, bench: Bench | None) -> Settings:
    from spiraltrunk.calibration.calibrate import Settings, Weighing
    from spiraltrunk.workflows.calibrate.joint_bench import compute_prior

    joints = () if bench is None else compute_prior(bench)
    if arguments.mass_g is None:
        return Settings(bench=joints)
    mass = 1e-3 * float(arguments.mass_g)
    spread = 0.01 * mass if arguments.mass_sd_g is None else 1e-3 * float(arguments.mass_sd_g)
    return Settings(weighing=Weighing(mass=mass, spread=spread), bench=joints)


def _play(arguments: argparse.Namespace, design: TrunkDesign, protocol: Any) -> Answer:
    from spiraltrunk.workflows.virtual_session.printed_trunk import draw_world
    from spiraltrunk.workflows.virtual_session.session import play_session, write_session

    seed = arguments.seed or 0
    world = draw_world(design, seed)
    with show_progress(sys.stderr) as tell:
        played = play_session(design, world, protocol, progress=tell)
        tell("writing", 0, 1)
        files = [path.name for path in write_session(design, played, seed, arguments.virtual)]
    told = {
        "what": "virtual capture, not a measurement", "seed": seed, "design": design.name, "axes": "y-up",
        "mass_g": 1e3 * float(world.design.section_mass.sum()), "friction": world.design.cable.friction,
        "stiffness_nm_per_rad": world.design.joint_stiffness.tolist(), "slack_mm": (1e3 * world.winders.slack).tolist(),
        "center_fraction": world.design.mass.center_fraction, "hole_fraction": world.design.cable.hole_fraction,
        "give_mm_per_n": 1e3 * world.winders.compliance,
        "files": files,
    }  # fmt: skip
    text = (
        f"virtual capture, not a measurement: {len(files)} takes in {arguments.virtual}, axes y-up, the trunk weighs "
    )
    return DONE, format_json(told) if arguments.json else f"{text}{told['mass_g']:.1f} g"


def _fit(arguments: argparse.Namespace, recordings: Recordings, bench: Bench | None) -> Answer:
    from spiraltrunk.workflows.calibrate.artifacts import compute_result, run_calibration, write_calibration_folder

    settings = _read_settings(arguments, bench)
    with show_progress(sys.stderr) as progress:
        run = run_calibration(recordings, settings, bench, progress=progress)
        progress("report", 0, 1)
        result = compute_result(run) if arguments.out is None else write_calibration_folder(run, arguments.out)
    for note in (*result["notes"], *result["odd_in_recordings"]):
        complain(f"note: {note}", DONE)
    return DONE, format_json(result) if arguments.json else _format(result, arguments.out)


def _format(result: dict[str, Any], out: str | None) -> str:
    """Parameters and errors as tables."""
    from spiraltrunk.report import format_table

    rows = [
        (name, *(f"{p[key]:.4g}" for key in ("before", "value", "low_95", "high_95")), p["unit"],
         "" if p["is_told"] else "not told")
        for name, p in result["parameters"].items()
    ]  # fmt: skip
    header = ("parameter", "before", "fitted", "low", "high", "unit", "")
    text = format_table(rows, header=header, title="Parameters with 95 % intervals", indent=2)
    for part, words in (("held_out", "held out"), ("fitted", "fitted")):
        if result[part]:
            text += f"\n\n{_format_errors(result[part], words)}"
    if result["bench"] is not None:
        text += f"\n\n{calibrate_bench.format_bench(result['bench'])}"
    if result["to_record"]:
        text += "\n\nTo tell what is not told:\n" + "\n".join(f"  {words}" for words in result["to_record"])
    return text if out is None else f"{text}\n\n{len(result['files'])} files in {out}"


def _format_errors(errors: dict[str, Any], words: str) -> str:
    from spiraltrunk.report import format_table

    rows = [
        (name, str(row["shapes"]), *(_mm(row[f"{model}_mean_rmse_m"]) for model in _MODELS))
        for name, row in errors.items()
    ]
    header = ("shapes", "number", "calibrated", "as designed", "paper's model")
    return format_table(rows, header=header, title=f"Mean RMSE in mm, {words}", indent=2)


_MODELS = ("calibrated", "uncalibrated", "reference")


def _mm(value: float | None) -> str:
    return "-" if value is None else f"{1e3 * value:.2f}"
