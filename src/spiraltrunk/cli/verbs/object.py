"""``spiraltrunk object``: what an object is, from its measures or its file, or which ones have names."""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

from spiraltrunk.cli.arguments import add_parser, read_text
from spiraltrunk.cli.object_check import read_object
from spiraltrunk.cli.output import DONE, Answer, complain, format_json, name_option
from spiraltrunk.cli.plot_file import check_plot, read_format
from spiraltrunk.errors import DesignError, Unquoted

if TYPE_CHECKING:
    from spiraltrunk.sim.objects.description import Description


def add_verb(verbs: Any) -> None:
    """Add the verb and its arguments."""
    parser = add_parser(verbs, "object", _run, "tell what an object is: size, stable poses, widths, warnings")
    parser.add_argument(
        "object", type=read_text, nargs="?", metavar="SPEC",
        help="a catalogue name, a solid such as box:x_mm=62,y_mm=62,z_mm=190,mass_g=300, or a file such as "
        "stl:path=vase.stl,mass_g=250; without it, the catalogue is listed",
    )  # fmt: skip
    parser.add_argument(
        "--design", type=read_text, metavar="DESIGN", help="tell also what this trunk can take: preset or TOML file"
    )
    parser.add_argument("--plot", type=read_text, metavar="FILE", help="plot it to a .png, .svg or .pdf file")


def _run(arguments: argparse.Namespace) -> Answer:
    if arguments.object is None:
        return _list_catalogue(arguments)
    if arguments.plot is not None:
        check_plot(Path(arguments.plot))
    from spiraltrunk.files.results import to_json
    from spiraltrunk.sim.objects.description import describe_object, list_figures

    shape = read_object(arguments.object)
    about = describe_object(shape)
    figures = list_figures(about, arguments.object)
    if arguments.design is not None:
        figures["design"] = _compare(arguments.design, about)
    for warning in shape.warnings:
        complain(warning, DONE)
    if arguments.plot is not None:
        _plot(about, arguments.object, arguments.plot)
    figures = dict(to_json(figures))
    return DONE, format_json(figures) if arguments.json else _format_table(figures)


def _list_catalogue(arguments: argparse.Namespace) -> Answer:
    """Names of the catalogue and what they stand for."""
    from spiraltrunk.report import format_table
    from spiraltrunk.sim.objects.catalogue import CATALOGUE

    for option in ("design", "plot"):
        if getattr(arguments, option) is not None:
            raise DesignError("SPEC", got=Unquoted("missing"), allowed=f"an object, which --{option} is about")
    if arguments.json:
        return DONE, format_json({"objects": [{"name": name, "spec": spec} for name, spec in CATALOGUE.items()]})
    return DONE, format_table(list(CATALOGUE.items()), header=("name", "stands for"), indent=2)


def _compare(name: str, about: Description) -> dict[str, Any]:
    """What a trunk takes, beside what the object asks for."""
    from spiraltrunk.design import graspable_range, load_design, payload
    from spiraltrunk.strategies.fingertip.assess import held_width
    from spiraltrunk.strategies.wrap.assess import held_mass, wrapped_range
    from spiraltrunk.strategies.wrap.standing_model import least_width

    design = load_design(name)
    widths, held = graspable_range(design), wrapped_range(design)
    if not widths.is_empty:  # Of what is tall, less than the trunk's loop.
        held = least_width(design, float(about.profile.height[-1])), held[1]
    gripper = design.gripper
    girth = float(about.profile.girth.max()) / math.pi
    is_wrapped = widths.minimum <= girth <= widths.maximum
    return {
        "name": design.name,
        "wrap_widths_m": None if widths.is_empty else list(widths),
        "wrap_width_m": girth,
        "payload_kg": payload(design, girth) if is_wrapped else None,
        "held_widths_m": None if held[1] < held[0] else list(held),
        "held_mass_kg": held_mass(design, girth) if is_wrapped else None,
        "finger_width_m": None if gripper is None else gripper.grasp_width,
        "finger_held_width_m": None if gripper is None else held_width(gripper),
    }


def _plot(about: Description, name: str, file: str) -> None:
    from spiraltrunk.files.output_file import write_output_file
    from spiraltrunk.report.object_plot import ObjectPicture, build_object_figure
    from spiraltrunk.report.style import format_figure

    form = read_format(Path(file))
    picture = ObjectPicture(
        title=f"{name}: {_measures(about.shape.size)} mm, {1e3 * about.shape.mass:.4g} g", triangles=about.triangles,
        profile=about.profile, center=about.center, notes=about.shape.warnings,
    )  # fmt: skip
    with name_option("--plot"):
        write_output_file(file, format_figure(build_object_figure(picture), form), form)


def _measures(extents: Any) -> str:
    return " x ".join(f"{1e3 * extent:.4g}" for extent in extents)


def _format_table(figures: dict[str, Any]) -> str:
    from spiraltrunk.report import format_table

    mm = {key: f"{1e3 * figures[key]:.4g} mm" for key in ("support_radius_m", "grip_width_m", "grip_height_m")}
    x, y, z = (1e3 * value + 0.0 for value in figures["center_of_mass_m"])
    falls = _falls(figures["topple_deg"])
    rests = "in no stable pose" if figures["pose"] is None else f"in stable pose {figures['pose']}"
    rows = [
        ("extents", f"{_measures(figures['extents_m'])} mm, length x width x height as it rests"),
        ("rests", f"{rests}, {falls}; support radius {mm['support_radius_m']}"),
        ("mass", f"{_format_whole(1e3 * figures['mass_kg'])} g"),
        ("volume", f"{1e6 * figures['volume_m3']:.4g} cm3, {_format_whole(figures['density_kg_m3'])} kg/m3"),
        (
            "centre of mass",
            f"{z:.1f} mm high, {round(x, 1) + 0.0:.1f}, {round(y, 1) + 0.0:.1f} mm from the middle along length, width",
        ),
        ("least width to grip", f"{mm['grip_width_m']} at a height of {mm['grip_height_m']}"),
    ]
    for i, pose in enumerate(figures["stable_poses"]):
        share, tall = f"{100 * pose['probability']:.1f} %", f"{1e3 * pose['height_m']:.4g} mm tall"
        rows.append((f"stable pose {i}", f"{share}, {tall}, {_falls(pose['topple_deg'])}"))
    if "design" in figures:
        rows += _list_design(figures["design"])
    return "\n\n".join([format_table(rows, title=figures["object"], indent=2), _format_profile(figures["profile"])])


def _format_whole(value: float) -> str:
    """A number with four digits, and with all its whole ones."""
    return f"{value:.0f}" if value >= 1e3 else f"{value:.4g}"


def _falls(tilt: float) -> str:
    return f"falls over at {tilt:.0f} deg" if tilt > 0 else "rolls"


def _list_design(design: dict[str, Any]) -> list[tuple[str, str]]:
    name, girth = design["name"], design["wrap_width_m"]
    opened, gripped = design["finger_width_m"], design["finger_held_width_m"]
    payload, held = design["payload_kg"], design["held_mass_kg"]
    around, holds = (
        "nothing: the trunk is too short to wrap"
        if design[key] is None
        else "{:.0f} to {:.0f} mm wide".format(*(1e3 * width for width in design[key]))
        for key in ("wrap_widths_m", "held_widths_m")
    )
    most, least = ("" if mass is None else f", {1e3 * mass:.0f} g" for mass in (payload, held))
    fingers = "no fingers" if opened is None else f"open {1e3 * opened:.0f} mm, hold up to {1e3 * gripped:.0f} mm"
    return [
        ("wraps as", f"a cylinder of {1e3 * girth:.0f} mm"),
        (f"{name} goes round", f"{around}{most}, by the paper's formulas"),
        (f"{name} holds", f"{holds}{least}, as far as simulated trials tell"),
        (f"fingers of {name}", fingers),
    ]


def _format_profile(profile: dict[str, Any]) -> str:
    """Ten sections from the top down."""
    from spiraltrunk.report import format_table

    keys = ("height_m", "width_least_m", "width_most_m", "girth_m")
    columns = [profile[key] for key in keys]
    count = len(columns[0])
    places = [round(i * (count - 1) / 10) for i in range(10, -1, -1)]
    rows = [[f"{1e3 * column[place]:.1f}" for column in columns] for place in places]
    header = ("height [mm]", "least width [mm]", "largest width [mm]", "girth [mm]")
    return format_table(rows, header=header, indent=2)
