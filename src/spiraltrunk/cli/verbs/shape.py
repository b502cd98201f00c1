"""``spiraltrunk shape``: one shape of the trunk, by the paper's forward model or by equilibrium."""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

from spiraltrunk.cli.arguments import Typed, add_parser, read_number, read_text
from spiraltrunk.cli.output import DONE, FAILED, Answer, UsageError, check_folder, format_json, quote
from spiraltrunk.cli.verbs.shape_load import LOADS, MODELS, Load, check_load, pick_model, read_load, solve_load

if TYPE_CHECKING:
    import numpy as np

    from spiraltrunk.design import TrunkDesign
    from spiraltrunk.model.kinematics.shape import Shape

_PICTURES = (".png", ".svg", ".pdf")
_MOST_TURN = 360.0
_MOST_FRICTION = 2.0


def add_verb(verbs: Any) -> None:
    """Add the verb and its arguments."""
    parser = add_parser(verbs, "shape", _run, "one shape of the trunk, at rest or with cables pulled")
    parser.add_argument(
        "design", type=read_text, nargs="?", default="paper", metavar="DESIGN",
        help="a preset or a TOML file (default paper); before --cables-mm and --tensions-n, if these are given",
    )  # fmt: skip
    parser.add_argument(
        "--model", choices=MODELS,
        help="reference: the paper's forward model; statics: equilibrium of joints, weight and cables. Default "
        "statics with --cables-mm and --tensions-n, which reference does not know, else reference",
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
        help="coefficient between cables and holes, statics only (default: the design's)",
    )  # fmt: skip
    parser.add_argument("--plot", type=read_text, metavar="FILE", help="draw it: FILE ends in .png, .svg or .pdf")


def _read_listed(text: str) -> Typed:
    """A number of a list without end, which takes in what follows it."""
    try:
        return read_number(text)
    except argparse.ArgumentTypeError as error:
        raise argparse.ArgumentTypeError(f"{error}, and DESIGN before the option") from None


def _run(arguments: argparse.Namespace) -> Answer:
    load = read_load(arguments)
    model = pick_model(arguments.model, load)
    _check_numbers(arguments, model)
    if arguments.plot is not None:
        _check_picture(arguments.plot)
    from spiraltrunk.design import load_design

    design = load_design(arguments.design)
    check_load(design, load)
    theta_0 = math.radians(arguments.theta0_deg)
    shape = solve_load(design, load, model, theta_0, arguments.friction)
    figures = compute_figures(design, shape, model, load)
    figures["theta0_deg"] = float(arguments.theta0_deg)
    if model == "statics":
        figures["friction"] = design.cable.friction if arguments.friction is None else float(arguments.friction)
    if arguments.plot is not None:
        _draw(design, shape, theta_0, arguments.plot, _title(figures, with_status=True))
    text = format_json(figures) if arguments.json else _format_table(figures)
    return FAILED if figures["status_code"] == "NOT_CONVERGED" else DONE, text


def _check_numbers(arguments: argparse.Namespace, model: str) -> None:
    turn, mu = arguments.theta0_deg, arguments.friction
    if abs(turn) > _MOST_TURN:
        raise UsageError(f"--theta0-deg is {turn.text}; allowed: -{_MOST_TURN:g} to {_MOST_TURN:g} deg")
    if mu is not None and model != "statics":
        raise UsageError(f"--friction given with the model {model}; allowed: --model statics, {model} knows none")
    if mu is not None and not 0.0 <= mu < _MOST_FRICTION:
        raise UsageError(f"--friction is {mu.text}; allowed: 0 or more, below {_MOST_FRICTION:g}")


def _check_picture(file: str) -> None:
    path = Path(file)
    if path.suffix.lower() not in _PICTURES:
        raise UsageError(f"--plot: {quote(file)} given; allowed: a file that ends in {', '.join(_PICTURES)}")
    if path.is_dir():
        raise UsageError(f"--plot: {quote(file)} is a folder; allowed: a file, existing or new")
    try:
        check_folder(str(path.parent))
    except UsageError as error:
        raise UsageError(str(error).replace("--out", "--plot", 1)) from None


def _draw(design: TrunkDesign, shape: Shape, theta_0: float, file: str, title: str) -> None:
    from spiraltrunk.report.shape.shape_plot import build_shape_figure
    from spiraltrunk.report.style import write_figure

    try:
        write_figure(build_shape_figure(design, shape, theta_0, title=title), file)
    except OSError as error:  # It names the draft, which nobody typed.
        why = error.strerror or str(error)
        raise UsageError(
            f"--plot: cannot write {quote(file, 200)}: {why}; allowed: a place that can be made and written"
        ) from None


def compute_figures(design: TrunkDesign, shape: Shape, model: str, load: Load | None) -> dict[str, Any]:
    """What is known of a shape, by the keys of ``spiraltrunk shape --json``, without base angle and friction."""
    import numpy as np

    from spiraltrunk.model.kinematics.shape import Status
    from spiraltrunk.model.statics.pull_sequences import find_shut

    tension = None if shape.forces is None else shape.forces.cable_tension.tolist()
    return {
        "design": design.name,
        "model": model,
        "load": None if load is None else {"option": load.option, "values": [float(value) for value in load.typed]},
        "points_m": shape.points.tolist(),
        "joint_angles_deg": np.degrees(shape.joint_angle).tolist(),
        "joint_is_shut": find_shut(design, shape).tolist(),
        "cable_change_m": shape.cable_change.tolist(),
        "cable_tension_n": tension,
        "status": shape.advice,
        "status_code": Status(int(shape.status)).name,
    }


def _title(figures: dict[str, Any], *, with_status: bool = False) -> str:
    load = figures["load"]
    done = "at rest" if load is None else " ".join([load["option"], *(f"{value:g}" for value in load["values"])])
    model = figures["model"] + (f" with friction {figures['friction']:g}" if "friction" in figures else "")
    turn, code = figures["theta0_deg"], figures["status_code"]
    base = f"base axis {abs(turn):g} deg {'above' if turn < 0 else 'below'} horizontal"
    ending = "" if code == "CONVERGED" or not with_status else f": {code.replace('_', ' ').lower()}"
    return f"{figures['design']}, {model}, {done}, {base}{ending}"


def _format_table(figures: dict[str, Any]) -> str:
    from spiraltrunk.report import format_table

    shut, tension = figures["joint_is_shut"], figures["cable_tension_n"]
    rows = [
        ("status", figures["status"]),
        ("tip", "x, y, z = " + ", ".join(f"{_round(1e3 * value):g}" for value in figures["points_m"][-1]) + " mm"),
        ("total bend", f"{sum(figures['joint_angles_deg']):.1f} deg over {len(shut)} joints"),
        ("joints shut", _name_joints(shut)),
    ]
    for cable, change in enumerate(figures["cable_change_m"]):
        shift = _round(1e3 * change)
        way = f"{abs(shift):g} mm {'in' if shift >= 0 else 'out'}"
        force = "" if tension is None else f", {_round(tension[cable], 2):g} N"
        rows.append((f"cable {cable + 1}", way + force))
    return format_table(rows, title=_title(figures), indent=2)


def _round(value: float, digits: int = 1) -> float:
    """Rounded, without a minus before zero."""
    return round(value, digits) + 0.0


def _name_joints(shut: list[bool] | np.ndarray) -> str:
    """Numbers of the joints that are shut, 1 at the base, runs of them as ``11-17``."""
    numbers = [joint for joint, is_shut in enumerate(shut, 1) if is_shut]
    runs: list[list[int]] = []
    for joint in numbers:
        if runs and runs[-1][-1] == joint - 1:
            runs[-1].append(joint)
        else:
            runs.append([joint])
    told = ", ".join(f"{run[0]}-{run[-1]}" if len(run) > 1 else f"{run[0]}" for run in runs)
    return f"{told} of 1-{len(shut)}, base to tip" if runs else "none"
