"""``spiraltrunk shape``: one shape of the trunk, by the paper's forward model or by equilibrium."""

from __future__ import annotations

import argparse
import math
from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING, Any

from spiraltrunk.cli.arguments import Typed, add_parser, read_number, read_text
from spiraltrunk.cli.output import DONE, FAILED, Answer, UsageError, format_json, name_option
from spiraltrunk.cli.plot_file import check_plot, read_format
from spiraltrunk.cli.verbs.shape.load import LOADS, MODELS, Load, pick_model, read_load, solve_load

if TYPE_CHECKING:
    from spiraltrunk.design import TrunkDesign
    from spiraltrunk.model.kinematics.shape import Shape

_MOST_DEG = 360
"""Largest angle of the base axis [deg]."""


def add_verb(verbs: Any) -> None:
    """Add the verb and its arguments."""
    parser = add_parser(verbs, "shape", _run, "compute one shape of the trunk, at rest or with cables pulled")
    parser.add_argument(
        "design", type=read_text, nargs="?", default="paper", metavar="DESIGN",
        help="preset or TOML file (default paper); before --cables-mm and --tensions-n",
    )  # fmt: skip
    parser.add_argument(
        "--model", choices=MODELS,
        help="reference: the paper's forward model; statics: equilibrium of joints, weight and cables. Default "
        "statics with --cables-mm and --tensions-n, else reference",
    )  # fmt: skip
    parser.add_argument(
        "--theta0-deg", type=read_number, default=90.0, metavar="DEG",
        help="angle of the base axis below the horizontal: 90 hangs (default), 0 lies, -90 stands",
    )  # fmt: skip
    for name, spec in LOADS.items():
        parser.add_argument(
            spec.option, dest=name, type=read_number if isinstance(spec.numbers, int) else _read_listed,
            nargs=spec.numbers, metavar=spec.metavar, help=spec.help,
        )  # fmt: skip
    parser.add_argument(
        "--friction", type=read_number, metavar="MU",
        help="coefficient between cables and holes, for statics (default: the design's)",
    )  # fmt: skip
    parser.add_argument("--plot", type=read_text, metavar="FILE", help="plot it to a .png, .svg or .pdf file")


def _read_listed(text: str) -> Typed:
    """A number of a list of any length, which would include a DESIGN after it."""
    try:
        return read_number(text)
    except argparse.ArgumentTypeError as error:
        raise argparse.ArgumentTypeError(f"{error}, and DESIGN before the option") from None


def _run(arguments: argparse.Namespace) -> Answer:
    load = read_load(arguments)
    model = pick_model(arguments.model, load)
    if arguments.friction is not None and model == "reference":
        raise UsageError("--friction given with the model reference; allowed: --model statics, reference has none")
    if abs(arguments.theta0_deg) > _MOST_DEG:
        allowed = f"a finite number, at least -{_MOST_DEG}, at most {_MOST_DEG}"
        raise UsageError(f"--theta0-deg is {arguments.theta0_deg:g}; allowed: {allowed}")
    if arguments.plot is not None:
        check_plot(Path(arguments.plot))
    from spiraltrunk.design import load_design

    design = load_design(arguments.design)
    theta_0 = math.radians(arguments.theta0_deg)
    shape = solve_load(design, load, model, theta_0, arguments.friction)
    figures = compute_figures(design, shape, model, load)
    figures["theta0_deg"] = float(arguments.theta0_deg)
    if model == "statics":
        figures["friction"] = design.cable.friction if arguments.friction is None else float(arguments.friction)
    if arguments.plot is not None:
        _plot(design, shape, theta_0, arguments.plot, _title(figures, with_status=True))
    text = format_json(figures) if arguments.json else _format_table(figures)
    return FAILED if figures["status_code"] == "NOT_CONVERGED" else DONE, text


def _plot(design: TrunkDesign, shape: Shape, theta_0: float, file: str, title: str) -> None:
    from spiraltrunk.files.output_file import write_output_file
    from spiraltrunk.report.shape.shape_plot import build_shape_figure
    from spiraltrunk.report.style import format_figure

    form = read_format(Path(file))
    data = format_figure(build_shape_figure(design, shape, theta_0, title=title), form)
    with name_option("--plot"):
        write_output_file(file, data, form)


def compute_figures(design: TrunkDesign, shape: Shape, model: str, load: Load | None) -> dict[str, Any]:
    """Figures of a shape by the keys of ``spiraltrunk shape --json``, without base angle and friction."""
    import numpy as np

    from spiraltrunk.files.results import to_json
    from spiraltrunk.model.kinematics.shape import Status
    from spiraltrunk.model.statics.pull_sequences import find_shut

    figures = {
        "design": design.name,
        "model": model,
        "load": None if load is None else {"option": load.option, "values": load.numbers},
        "points_m": shape.points,
        "joint_angles_deg": np.degrees(shape.joint_angle),
        "joint_is_shut": find_shut(design, shape),
        "cable_change_m": shape.cable_change,
        "cable_tension_n": None if shape.forces is None else shape.forces.cable_tension,
        "status": shape.advice,
        "status_code": Status(int(shape.status)).name,
    }
    return dict(to_json(figures))


def _title(figures: dict[str, Any], *, with_status: bool = False) -> str:
    load = figures["load"]
    cables = "at rest" if load is None else " ".join([load["option"], *(f"{value:g}" for value in load["values"])])
    model = figures["model"] + (f" with friction {figures['friction']:g}" if "friction" in figures else "")
    angle, code = figures["theta0_deg"], figures["status_code"]
    base = f"base axis {abs(angle):g} deg {'above' if angle < 0 else 'below'} horizontal"
    ending = "" if code == "CONVERGED" or not with_status else f": {code.replace('_', ' ').lower()}"
    return f"{figures['design']}, {model}, {cables}, {base}{ending}"


def _format_table(figures: dict[str, Any]) -> str:
    from spiraltrunk.report import format_table

    shut, tension = figures["joint_is_shut"], figures["cable_tension_n"]
    rows = [
        ("status", figures["status"]),
        ("tip", "x, y, z = " + ", ".join(f"{_round(1e3 * value):g}" for value in figures["points_m"][-1]) + " mm"),
        ("total bend", f"{sum(figures['joint_angles_deg']):.1f} deg over {len(shut)} joints"),
        ("joints shut", _format_joints(shut)),
    ]
    for cable, change in enumerate(figures["cable_change_m"]):
        shift = _round(1e3 * change)
        force = "" if tension is None else f", {_round(tension[cable], 2):g} N"
        rows.append((f"cable {cable + 1}", f"{abs(shift):g} mm {'in' if shift >= 0 else 'out'}{force}"))
    return format_table(rows, title=_title(figures), indent=2)


def _round(value: float, digits: int = 1) -> float:
    """Rounded, without a minus before zero."""
    return round(value, digits) + 0.0


def _format_joints(shut: list[bool]) -> str:
    """Numbers of the shut joints, 1 at the base, runs of them as ``11-17``."""
    runs = [
        [joint for joint, _ in run] for is_shut, run in groupby(enumerate(shut, 1), lambda pair: pair[1]) if is_shut
    ]
    listed = ", ".join(f"{run[0]}-{run[-1]}" if len(run) > 1 else f"{run[0]}" for run in runs)
    return f"{listed} of 1-{len(shut)}, base to tip" if runs else "none"
