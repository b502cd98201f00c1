"""``spiraltrunk design``: a trunk from the paper's rules, or a preset."""

from __future__ import annotations

import argparse
import math
from typing import TYPE_CHECKING, Any

from spiraltrunk.cli.arguments import Typed, add_parser, read_number, read_text
from spiraltrunk.cli.output import DONE, Answer, UsageError, format_json, name_option, quote
from spiraltrunk.errors import DesignError, Unquoted

if TYPE_CHECKING:
    from spiraltrunk.design import TrunkDesign

_WISHES = {
    "m": "--m", "b": "--b", "delta_theta": "--delta-theta-deg", "arm_radius": "--arm-radius-mm", "turns": "--turns",
}  # fmt: skip
"""Option of each wish of `design_from_rules`."""


def add_verb(verbs: Any) -> None:
    """Add the verb and its arguments."""
    parser = add_parser(
        verbs, "design", _run, "compute a trunk by the paper's rules: spiral, sections, graspable range, payload"
    )
    help_of = {
        "m": "smallest graspable object over the tip's width; a small m gives a slender tip (default 1.53)",
        "b": "growth of the spiral per radian, instead of --m",
        "delta_theta": "angle of one section, which must divide the turns into whole sections (default 30)",
        "arm_radius": "radius of the arm's last link (default 44)",
        "turns": "turns of the spiral (default 1.5)",
    }
    for wish, option in _WISHES.items():
        metavar = {"deg": "DEG", "mm": "MM"}.get(option.rpartition("-")[2], "N")
        parser.add_argument(option, dest=wish, type=read_number, metavar=metavar, help=help_of[wish])
    parser.add_argument("--preset", type=read_text, metavar="NAME", help="a preset instead of the rules")
    parser.add_argument("--out", type=read_text, metavar="FILE", help="write the design there as TOML")


def _run(arguments: argparse.Namespace) -> Answer:
    from spiraltrunk.files.output_file import check_output_file, write_output_file

    if arguments.out is not None:
        if arguments.out.endswith("/"):
            raise UsageError(f"--out: {quote(arguments.out, 200)} is a folder; allowed: a file, existing or new")
        with name_option("--out"):
            check_output_file(arguments.out, "toml")
    from spiraltrunk.design import format_design, presets

    wishes = {wish: getattr(arguments, wish) for wish in _WISHES if getattr(arguments, wish) is not None}
    if arguments.preset is None:
        design = _design_from(wishes)
    elif wishes:
        *others, last = _WISHES.values()
        raise UsageError(f"--preset given with rules; allowed: either --preset or {', '.join(others)}, {last}")
    else:
        design = presets.get(arguments.preset)
    figures = compute_figures(design)
    if arguments.out is not None:
        with name_option("--out"):
            write_output_file(arguments.out, format_design(design).encode(), "toml")
    return DONE, format_json(figures) if arguments.json else _format_table(design, figures)


def _design_from(wishes: dict[str, Typed]) -> TrunkDesign:
    """The rules' design; an error names the option, with value and range in its unit."""
    from spiraltrunk.design import design_from_rules
    from spiraltrunk.design.schema import DEGREE, MILLI, ONE, convert_error

    if {"m", "b"} <= wishes.keys():
        raise UsageError("--m and --b given; allowed: one of them, as m = 1 / (exp(pi b) - 1)")
    unit = {"delta_theta": DEGREE, "arm_radius": MILLI}
    try:
        return design_from_rules(
            m=wishes.get("m"),
            b=wishes.get("b"),
            delta_theta=math.radians(wishes.get("delta_theta", 30.0)),
            arm_radius=wishes.get("arm_radius", 44.0) / 1000.0,
            turns=wishes.get("turns", 1.5),
        )
    except DesignError as error:
        if error.name not in _WISHES:
            raise UsageError(f"{_retype(wishes)}: {error}") from None
        if error.name not in wishes:
            raise _refuse_turns(wishes["turns"]) from None
        typed = Unquoted(wishes[error.name].text)
        raise convert_error(error, _WISHES[error.name], unit.get(error.name, ONE), typed) from None


def _refuse_turns(turns: Typed, angle: float = 30.0) -> DesignError:
    """Error for turns that are no whole number of sections of the default angle [deg]."""
    few = math.floor(360 * turns / angle)
    near = " or ".join(f"{n * angle / 360:.9g} ({n} sections)" for n in (few, few + 1))
    return DesignError("--turns", got=Unquoted(turns.text), allowed=f"whole sections of {angle:g} deg, such as {near}")


def _retype(wishes: dict[str, Typed]) -> str:
    return " ".join(f"{_WISHES[wish]} {value.text}" for wish, value in wishes.items()) or "this design"


def compute_figures(design: TrunkDesign) -> dict[str, Any]:
    """Figures of a design by the keys of ``spiraltrunk design --json``."""
    from spiraltrunk.design import graspable_range, payload
    from spiraltrunk.files.results import to_json

    widths = graspable_range(design)
    smallest, largest = (None, None) if widths.is_empty else widths
    figures = {
        "a_m": design.spiral.a,
        "b": design.spiral.b,
        "k": design.k,
        "k_p": design.k_p,
        "n_section": design.n_section,
        "n_joint": design.n_joint,
        "section_length_m": design.section_length,
        "section_radius_m": design.section_radius,
        "length_m": design.length,
        "tip_width_m": design.tip_width,
        "base_width_m": design.base_width,
        "taper_deg": math.degrees(design.taper),
        "graspable_min_m": smallest,
        "graspable_max_m": largest,
        "cable_stroke_m": design.cable_stroke,
        "joint_stiffness_nm_per_rad": design.joint_stiffness,
        "mass_kg": design.total_mass,
        "payload_kg": None if widths.is_empty else payload(design),
    }
    return dict(to_json(figures))


def _list_grasp(figures: dict[str, Any]) -> list[tuple[str, str]]:
    """What the trunk wraps."""
    if figures["graspable_min_m"] is None:
        return [("graspable", "nothing: the trunk is too short to wrap")]
    smallest, largest = (f"{1e3 * figures[key]:.4g} mm" for key in ("graspable_min_m", "graspable_max_m"))
    return [
        ("graspable", f"{smallest} to {largest}"),
        ("payload", f"{figures['payload_kg']:.3g} kg at the smallest object (fitted to the paper's one number)"),
    ]


def _format_table(design: TrunkDesign, figures: dict[str, Any]) -> str:
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
        *_list_grasp(figures),
        ("cable stroke", mm("cable_stroke_m")),
        ("joint stiffness", both_ends(stiffness[0], stiffness[-1], "N m/rad")),
        ("mass", f"{figures['mass_kg'] * 1e3:.4g} g"),
    ]
    return format_table(rows, title=f"Trunk {design.name}", indent=2)
