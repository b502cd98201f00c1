"""The command line. Heavy packages are imported by the verbs that need them, so that help comes at once."""

from __future__ import annotations

import argparse
import math
import os
import re
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING, Any, NoReturn, TextIO

from spiraltrunk import __version__
from spiraltrunk.errors import DesignError, RunError, SpiralTrunkError

if TYPE_CHECKING:
    from spiraltrunk.bench import Claim
    from spiraltrunk.design import TrunkDesign

DONE, FAILED, BAD_INPUT, INTERRUPTED = 0, 1, 2, 130
"""Exit codes."""

Answer = tuple[int, str]
"""Exit code and the text for standard output."""

_MOST_SEED = 2**32
_LONGEST_LINE = 700
_GL = ("", "egl", "glfw", "glx", "osmesa", "cgl", "wgl", "on", "true", "1", "enable", "enabled", "off", "false", "0",
       "disable", "disabled")  # fmt: skip
_WORKERS = 2
"""Processes that draw a video: software OpenGL uses threads by itself, so more gain nothing."""


def main(argv: Sequence[str] | None = None) -> int:
    """Run a verb and return the exit code; errors that the package raises on purpose are one line."""
    _prepare_environment()
    try:
        arguments = _build_parser().parse_args(argv)
        code, text = arguments.verb(arguments)
        return _put(code, text)
    except SystemExit as stop:  # Help and version.
        return int(stop.code or 0)
    except KeyboardInterrupt:
        return _complain("interrupted", INTERRUPTED)
    except BrokenPipeError:
        return DONE
    except RunError as error:
        return _complain(f"error: {error}", FAILED)
    except (SpiralTrunkError, _UsageError) as error:
        return _complain(f"error: {error}", BAD_INPUT)
    except OSError as error:
        where = f" {error.filename!r}" if error.filename else ""
        return _complain(f"error: cannot write{where}: {error.strerror or error}", BAD_INPUT)


class _UsageError(Exception):
    """Arguments that make no command."""


class _Parser(argparse.ArgumentParser):
    """Argument parser that raises instead of printing its usage."""

    def error(self, message: str) -> NoReturn:
        raise _UsageError(f"{message}; see {self.prog} --help")


def _prepare_environment() -> None:
    """Settings that packages read when they are imported: no threads for small matrices, OpenGL without a display."""
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    if not os.environ.get("MUJOCO_GL") and not os.environ.get("DISPLAY"):
        os.environ["MUJOCO_GL"] = "egl"


def _put(code: int, text: str) -> int:
    """Print the answer; a reader that has left is no error, a full disc is."""
    try:
        print(text)
        sys.stdout.flush()
    except OSError as error:
        # Python would complain once more at exit, where it flushes what is left.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        if not isinstance(error, BrokenPipeError):
            raise
    return code


def _complain(message: str, code: int) -> int:
    line = " ".join(message.split())
    line = "".join(letter if letter.isprintable() else ascii(letter)[1:-1] for letter in line)
    if len(line) > _LONGEST_LINE:
        half = _LONGEST_LINE // 2
        line = f"{line[:half]} ... {line[-half:]}"
    with suppress(OSError):  # Nobody listens.
        print(f"spiraltrunk: {line}", file=sys.stderr, flush=True)
    return code


# Arguments.


def _build_parser() -> _Parser:
    parser = _Parser(
        prog="spiraltrunk",
        description="From a logarithmic-spiral soft trunk on paper to the trunk grasping on a robot arm.",
        allow_abbrev=False,
    )
    parser.add_argument("--version", action="version", version=f"spiraltrunk {__version__}")
    verbs = parser.add_subparsers(required=True, metavar="VERB")

    design = _add_verb(verbs, "design", _design, "the paper's rules: spiral, sections, graspable range, payload")
    design.add_argument("--m", type=_number, help="largest over smallest object per base width (default 1.53)")
    design.add_argument("--b", type=_number, help="growth of the spiral per radian, instead of --m")
    design.add_argument("--delta-theta-deg", type=_number, help="angle of one section (default 30)")
    design.add_argument("--arm-radius-mm", type=_number, help="radius of the arm's last link (default 44)")
    design.add_argument("--turns", type=_number, help="turns of the spiral (default 1.5)")
    design.add_argument("--preset", type=_text, metavar="NAME", help="a known robot instead of the rules")
    design.add_argument("--out", type=_text, metavar="FILE", help="write the design there as TOML")

    grasp = _add_verb(verbs, "grasp", _grasp, "one trial in simulation")
    named = "a catalogue name, or a solid such as cylinder:diameter_mm=72,height_mm=180,mass_g=350"
    design_named = "a preset or a TOML file (default paper)"
    grasp.add_argument(
        "strategy", type=_text, nargs="?", default="wrap-vertical", metavar="STRATEGY", help="default wrap-vertical"
    )
    grasp.add_argument("--object", type=_text, metavar="NAME", help=named)
    grasp.add_argument("--design", type=_text, default="paper", metavar="DESIGN", help=design_named)
    grasp.add_argument("--seed", type=_seed, default=0, help="what the world is drawn from (default 0)")
    grasp.add_argument("--no-video", action="store_true", help="neither film strip nor video")
    grasp.add_argument("--out", type=_text, metavar="DIR", help="write result, design, plots and pictures there")

    bench = _add_verb(verbs, "bench", _bench, "the performance claims, each as a ratio measured now")
    bench.add_argument("--peers", action="store_true", help="against other packages as well")
    bench.add_argument("--out", type=_text, metavar="DIR", help="write result.json there")
    return parser


def _add_verb(
    verbs: Any, name: str, verb: Callable[[argparse.Namespace], Answer], what: str
) -> argparse.ArgumentParser:
    parser: argparse.ArgumentParser = verbs.add_parser(name, help=what, description=what, allow_abbrev=False)
    parser.add_argument("--json", action="store_true", help="one JSON object on standard output, nothing else there")
    parser.set_defaults(verb=verb)
    return parser


def _number(text: str) -> float:
    try:
        value = float(text) if text.isascii() and "_" not in text else math.nan
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError(f"{_short(text)} given; allowed: a finite number")
    return value


def _seed(text: str) -> int:
    if not re.fullmatch(r"[0-9]{1,10}", text) or int(text) >= _MOST_SEED:
        raise argparse.ArgumentTypeError(f"{_short(text)} given; allowed: a whole number from 0 to {_MOST_SEED - 1}")
    return int(text)


def _text(text: str) -> str:
    if not text or "\0" in text:
        raise argparse.ArgumentTypeError(f"{_short(text)} given; allowed: a text that is not empty")
    return text


def _short(text: str, most: int = 60) -> str:
    return repr(text if len(text) <= most else f"{text[:most]}...")


# Verbs.


def _design(arguments: argparse.Namespace) -> Answer:
    from spiraltrunk.design import load_design, presets, write_design

    wishes = _read_wishes(arguments)
    if arguments.preset is None:
        design = _design_from(wishes)
    elif wishes:
        raise _UsageError("--preset given with rules; allowed: either --preset or --m, --b, --delta-theta-deg, "
                          "--arm-radius-mm, --turns")  # fmt: skip
    else:
        design = presets.get(arguments.preset)
    _check_fits(design)
    figures = compute_figures(design)
    if arguments.out is not None:
        write_design(design, arguments.out)
        load_design(arguments.out)
    return DONE, _format_json(figures) if arguments.json else _format_design_table(design, figures)


def _read_wishes(arguments: argparse.Namespace) -> dict[str, float]:
    """The rules' options that were given, in the units in which they were given."""
    from spiraltrunk.design.checks import check_number

    ranges = {"m": (0.0, 1e6), "b": (1e-6, 2.0), "delta_theta_deg": (1.0, 90.0), "arm_radius_mm": (1e-3, 1e4),
              "turns": (0.0, 10.0)}  # fmt: skip
    wishes = {}
    for name, (above, below) in ranges.items():
        value = getattr(arguments, name)
        if value is not None:
            check_number(f"--{name.replace('_', '-')}", value, above=above, below=below)
            wishes[name] = value
    return wishes


def _design_from(wishes: dict[str, float]) -> TrunkDesign:
    from spiraltrunk.design import design_from_rules

    return design_from_rules(
        m=wishes.get("m"),
        b=wishes.get("b"),
        delta_theta=math.radians(wishes.get("delta_theta_deg", 30.0)),
        arm_radius=wishes.get("arm_radius_mm", 44.0) / 1000.0,
        turns=wishes.get("turns", 1.5),
    )


def compute_figures(design: TrunkDesign) -> dict[str, Any]:
    """What a design comes to, by the keys of ``spiraltrunk design --json``."""
    from spiraltrunk.design import graspable_range, payload

    smallest, largest = graspable_range(design)
    return {
        "a_m": design.spiral.a,
        "b": design.spiral.b,
        "k": design.k,
        "k_p": design.k_p,
        "n_section": design.n_section,
        "n_joint": design.n_joint,
        "section_length_m": [float(value) for value in design.section_length],
        "section_radius_m": [float(value) for value in design.section_radius],
        "length_m": float(design.length),
        "tip_width_m": float(design.tip_width),
        "base_width_m": float(design.base_width),
        "taper_deg": math.degrees(design.taper),
        "graspable_min_m": float(smallest),
        "graspable_max_m": float(largest),
        "cable_stroke_m": design.cable_stroke,
        "joint_stiffness_nm_per_rad": [float(value) for value in design.joint_stiffness],
        "mass_kg": design.total_mass,
        "payload_kg": payload(design),
    }


def _check_fits(design: TrunkDesign) -> None:
    """Refuse a design whose figures are no numbers, as at the ends of what floating point can hold."""
    for name, value in compute_figures(design).items():
        parts = value if isinstance(value, list) else [value]
        if not all(math.isfinite(part) and part > 0 for part in parts):
            raise DesignError(name, got=value if len(parts) == 1 else "not finite", allowed="finite, above 0")


def _format_design_table(design: TrunkDesign, figures: dict[str, Any]) -> str:
    from spiraltrunk.report import format_table

    def mm(name: str) -> str:
        return f"{figures[name] * 1e3:.4g} mm"

    def both_ends(first: float, last: float, unit: str) -> str:
        return f"{first:.4g} {unit} at the base to {last:.4g} {unit} at the tip"

    stiffness, lengths, radii = design.joint_stiffness, 1e3 * design.section_length, 1e3 * design.section_radius
    rows = [
        ("spiral", f"a = {mm('a_m')}, b = {design.spiral.b:.6g}, k = {design.k:.4g}"),
        ("sections", f"{design.n_section}, each {design.k_p:.4g} times the one before"),
        ("section lengths", both_ends(lengths[0], lengths[-1], "mm")),
        ("section radii", both_ends(radii[0], radii[-1], "mm")),
        ("length", mm("length_m")),
        ("width", both_ends(1e3 * design.base_width, 1e3 * design.tip_width, "mm")),
        ("taper", f"{figures['taper_deg']:.4g} deg"),
        ("graspable", f"{mm('graspable_min_m')} to {mm('graspable_max_m')}"),
        ("payload", f"{figures['payload_kg']:.3g} kg at the smallest object (fitted to the paper's one number)"),
        ("cable stroke", mm("cable_stroke_m")),
        ("joint stiffness", both_ends(stiffness[0], stiffness[-1], "N m/rad")),
        ("mass", f"{figures['mass_kg'] * 1e3:.4g} g"),
    ]
    return format_table(rows, title=f"Trunk {design.name}", indent=2)


def _grasp(arguments: argparse.Namespace) -> Answer:
    if os.environ.get("MUJOCO_GL", "").lower().strip() not in _GL:
        raise _UsageError(f"MUJOCO_GL is {_short(os.environ['MUJOCO_GL'])}; allowed: egl, osmesa, glfw or unset")
    from spiraltrunk import strategies
    from spiraltrunk.design import load_design
    from spiraltrunk.record import compute_result, open_record, write_record
    from spiraltrunk.sim.objects import DEFAULT_OBJECT, parse_object
    from spiraltrunk.trial import run_trial

    strategies.get(arguments.strategy)
    name = DEFAULT_OBJECT if arguments.object is None else arguments.object
    shape, design = parse_object(name), load_design(arguments.design)

    def run_watched(tell: Callable[[str, int, int], None]) -> Any:
        return run_trial(
            design, shape, strategy=arguments.strategy, seed=arguments.seed,
            watch=lambda seen, status: tell(status.phase, 0, 0),
        )  # fmt: skip

    missing = None
    if arguments.out is None:
        with _show_progress(sys.stderr) as tell:
            result = compute_result(run_watched(tell), name)
    else:
        with open_record(arguments.out) as draft, _show_progress(sys.stderr) as tell:
            record = write_record(
                run_watched(tell), name, draft, video=not arguments.no_video, workers=_WORKERS, tell=tell
            )
            result, missing = record.result, record.missing
    if missing is not None:
        _complain(f"no film strip and no video: {missing}", DONE)
    code = DONE if result["success"] else FAILED
    return code, _format_json(result) if arguments.json else _format_verdict(result, arguments.out)


def _format_verdict(result: dict[str, Any], out: str | None) -> str:
    from spiraltrunk.report import format_table

    head = "success" if result["success"] else f"failed: {result['reason']}"
    rows = [
        ("lifted", f"{_scaled(result['lift_m'], 1e3)} mm"),
        ("carried", f"{_scaled(result['carry_m'], 1e3)} mm"),
        ("held by the trunk alone", f"{_scaled(result['hold_s'])} s"),
        ("set down from the target", f"{_scaled(result['place_error_m'], 1e3)} mm"),
        ("deepest overlap", f"{_scaled(result['max_penetration_m'], 1e3)} mm"),
        ("largest joint angle", f"{_scaled(result['max_joint_deg'])} deg"),
        ("speed", f"{_scaled(result['real_time_factor'])} times real time"),
    ]
    title = f"{result['strategy']}, {result['object']}, seed {result['seed']}: {head}"
    table = format_table(rows, title=title, indent=2)
    return table if out is None else f"{table}\n  {len(result['files'])} files in {out}"


def _scaled(value: float | None, factor: float = 1.0) -> str:
    return "-" if value is None else f"{value * factor:.3g}"


@contextmanager
def _show_progress(stream: TextIO) -> Iterator[Callable[[str, int, int], None]]:
    """A function to call with what is being done, how much of it is done and how much there is.

    On a terminal it draws a bar, elsewhere it says each new thing in one line.
    """
    if not stream.isatty():
        yield _speak_once(stream)
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

    columns = (SpinnerColumn(), TextColumn("{task.description:<12}"), BarColumn(), TimeElapsedColumn())
    with Progress(*columns, console=Console(file=stream), transient=True) as bar:
        task = bar.add_task("starting", total=None)

        def show(what: str, done: int, total: int) -> None:
            bar.update(task, description=what, completed=done, total=total or None)

        yield show


def _speak_once(stream: TextIO) -> Callable[[str, int, int], None]:
    last = ""

    def say(what: str, done: int, total: int) -> None:
        nonlocal last
        if what != last:
            last = what
            print(f"spiraltrunk: {what}", file=stream, flush=True)

    return say


def _bench(arguments: argparse.Namespace) -> Answer:
    from spiraltrunk.bench import CLAIMS
    from spiraltrunk.record import open_record

    if arguments.peers:
        _complain(f"no peer comparison exists yet for these claims: {', '.join(CLAIMS)}", DONE)
    if arguments.out is None:
        claims = _measure(CLAIMS)
    else:
        with open_record(arguments.out) as draft:
            claims = _measure(CLAIMS)
            (draft / "result.json").write_text(_format_json({"claims": claims}) + "\n")
    code = DONE if all(claim["holds"] for claim in claims.values()) else FAILED
    return code, _format_json({"claims": claims}) if arguments.json else _format_claims(claims)


def _measure(claims: dict[str, Callable[[], Claim]]) -> dict[str, dict[str, Any]]:
    with _show_progress(sys.stderr) as tell:
        measured = {}
        for i, (name, measure) in enumerate(claims.items()):
            tell(name, i, len(claims))
            measured[name] = measure()
    return {
        name: {"ours": claim.ours, "other": claim.other, "ratio": claim.ratio, "bar": claim.bar, "holds": claim.holds}
        for name, claim in measured.items()
    }


def _format_claims(claims: dict[str, dict[str, Any]]) -> str:
    from spiraltrunk.report import format_table

    header = ("claim", "ours", "other", "ratio", "bar", "")
    rows = [
        (name, f"{claim['ours']:.3g}", f"{claim['other']:.3g}", f"{claim['ratio']:.3g}", f"{claim['bar']:g}",
         "holds" if claim["holds"] else "missed")
        for name, claim in claims.items()
    ]  # fmt: skip
    return format_table(rows, header=header)


def _format_json(value: object) -> str:
    import json

    return json.dumps(value, indent=2, allow_nan=False)
