"""Assembly guide: print settings, tools, and the steps in order, each with what it needs, takes and ends in."""

from __future__ import annotations

import re
from collections.abc import Sequence

import spiraltrunk
from spiraltrunk.cad.components.options import MakeOptions
from spiraltrunk.cad.components.print_settings import find_settings
from spiraltrunk.cad.geometry.part import Part
from spiraltrunk.cad.output.bill_of_materials import Bill, escape
from spiraltrunk.cad.output.guide.step import Build, Step
from spiraltrunk.cad.output.guide.steps_cables import plan_cable_steps
from spiraltrunk.cad.output.guide.steps_housing import TORQUES, plan_housing_steps
from spiraltrunk.cad.output.guide.steps_parts import plan_part_steps
from spiraltrunk.design.materials import RIGID
from spiraltrunk.design.trunk import TrunkDesign


def list_steps(build: Build) -> list[Step]:
    """The steps for the groups that are made, in order."""
    planned = (*plan_part_steps(), *plan_housing_steps(), *plan_cable_steps())
    return [step.write(build) for step in planned if step.is_necessary(build)]


def format_guide(design: TrunkDesign, parts: Sequence[Part], bill: Bill, options: MakeOptions) -> str:
    """The guide as a Markdown page."""
    build = Build(design, options, tuple(parts), bill)
    steps = list_steps(build)
    lines = [*_introduce(build), *_list_settings(build), *_list_tools(steps), "## Steps", ""]
    made: dict[str, int] = {}
    for number, step in enumerate(steps, start=1):
        lines += _format_step(number, step, made, bill)
        made |= dict.fromkeys(step.makes, number)
    return "\n".join([*lines, *_other_dimensions(build)]) + "\n"


def _introduce(build: Build) -> list[str]:
    design, housing = build.design, build.design.housing
    soft = (
        f" It yields from {housing.filament.softening:g} degC under load, and the motors warm the housing: "
        f"`housing.material` in `trunk.toml` takes {', '.join(RIGID)}."
    )
    return [
        f"# Building {escape(design.name)}", "",
        "**Nothing was built from this guide yet.** No part was printed or cast by us, no motor turned. Every "
        "dimension comes from the design and was checked in the computer alone. Print settings, torques and "
        "electronics are our choice where no source is named. Write down what you find.", "",
        f"{design.n_section} sections, {1e3 * design.length:.0f} mm long{_split_length(build)}, "
        f"{1e3 * design.base_width:.0f} mm wide at the "
        f"base, {design.n_cable} cables, {'with' if build.has_gripper else 'without'} gripper. What to make and to buy "
        "is in `bom.md`, the parts are in `parts`, their pictures in `pictures`. Rigid parts are of "
        f"{housing.filament.name}.{soft}", "",
        "Dorsal is where cable 1 runs. Base is the end at the arm, tip the other. A screw in plastic is tightened by "
        f"hand, the short arm of the key as handle where only the long one reaches, at most {TORQUES} (our choice). "
        f"Mains voltage in the supply is work for "
        "who is trained for it.", "",
        f"This page was written by spiraltrunk {spiraltrunk.__version__}. Steps that export again need it installed "
        "with its CAD packages: `pip install '.[cad]'` in the folder of its source, where `README.md`, `SAFETY.md` and "
        "`docs/install.md` are. One name for one part: the double arm is the file `horn`; the round horn comes with "
        "the servo.", "",
        *(_PICTURES if "housing" in build.groups else ()),
    ]  # fmt: skip


_PICTURES = (
    "![parts taken apart; motors, servo, wedges and wiring are not drawn](pictures/exploded.png)", "",
    "![the open housing, seen from the trunk](pictures/top_view.svg)", "",
)  # fmt: skip
"""Pictures of the whole robot."""


def _split_length(build: Build) -> str:
    """How the trunk's length and the sizes of its printed pieces agree."""
    if build.design.gripper is None or "trunk" not in build.groups:
        return ""
    plate = 1e3 * build.design.length - build.body.end
    piece = "printed piece" if build.n_piece == 1 else f"{build.n_piece} printed pieces together"
    return (
        f" from the base joint to the plate of the gripper (the {piece} {build.body.end:.0f} mm, the plate, "
        f"which is printed with the gripper, {plate:.1f} mm; the channel takes the point off the base's cone, so a "
        "piece may measure up to 1 mm less)"
    )


def _list_settings(build: Build) -> list[str]:
    printed = [part for part in build.parts if not part.material.is_cast]
    if not printed:
        return []
    options = build.options
    lines = [
        "## Print settings", "",
        f"Nozzle {options.nozzle:g} mm. Bed at least {options.bed[0]:g} x {options.bed[1]:g} x {options.bed[2]:g} mm, "
        "the one the trunk was split for. Our choice, untried.", "",
        "| quantity | file | material | layer mm | walls | infill | stands on | supports |",
        "|---|---|---|---|---|---|---|---|",
    ]  # fmt: skip
    stems: dict[str, list[Part]] = {}
    for part in printed:
        stems.setdefault(re.sub(r"_?\d+$", "", part.name), []).append(part)
    for own in stems.values():
        settings, first, last = find_settings(own[0].name), own[0].name, own[-1].name
        names = escape(first if first == last else f"{first} to {last}")
        each = "" if own[0].count == 1 or len(own) == 1 else f" ({own[0].count} each)"
        lines.append(
            f"| {sum(part.count for part in own)}{each} | {names} | {own[0].material.name} | "
            f"{settings.layer(options):g} | {settings.lines} | {100 * settings.infill:.0f} % | {settings.stands_on} | "
            f"{settings.supports} |"
        )
    return [*lines, ""]


def _list_tools(steps: Sequence[Step]) -> list[str]:
    tools = dict.fromkeys(tool for step in steps for tool in step.tools)
    return ["## Tools", "", *(f"- {tool}" for tool in sorted(tools, key=str.casefold)), ""]


def _format_step(number: int, step: Step, made: dict[str, int], bill: Bill) -> list[str]:
    """One step; ``made`` gives the number of the step that made each thing so far."""
    lines = [f"### {number}. {step.title}"]
    if step.needs or step.tools:
        lines.append("")
    if step.needs:
        told = [f"{need} ({f'step {made[need]}' if need in made else 'from another export'})" for need in step.needs]
        lines.append(f"- Needs: {', '.join(told)}.")
    taken = [str(row) for place in step.takes for row in bill.bought if row.place == place]
    if taken:
        lines.append(f"- Take: {'; '.join(taken)}.")
    if step.tools:
        lines.append(f"- Tools: {', '.join(step.tools)}.")
    lines += ["", *(f"{k}. {text}" for k, text in enumerate(step.work, start=1)), ""]
    return [*lines, f"**Check:** {step.check}", "", f"Makes: {', '.join(step.makes)}.", ""]


def _other_dimensions(build: Build) -> list[str]:
    """How to export with measured motors and servos."""
    motor, servo, x = build.options.motor, build.options.servo, build.options
    if not {"housing", "drums", "horn"} & build.groups:
        return []
    bed = ", ".join(f"{size:g}" for size in x.bed)
    fields = f"length={servo.length:g}, width={servo.width:g}, lug_pitch={servo.lug_pitch:g}, "
    fields += f"shaft_offset={servo.shaft_offset:g}, hub_diameter={servo.hub_diameter:g}, turn={servo.turn:g}"
    return [
        "## Other dimensions", "",
        "With your numbers in place of ours (mm; `turn` in degrees), in Python, in this folder:", "",
        "```python",
        "from spiraltrunk.cad.components.options import MakeOptions, Motor, Servo",
        "from spiraltrunk.design import load_design",
        "from spiraltrunk.workflows.export.export import Request, export_robot",
        "",
        f"motor = Motor(floor_circle={motor.floor_circle:g}, rotor_circle={motor.rotor_circle:g}, "
        f"diameter={motor.diameter:g}, height={motor.height:g})",
        f"servo = Servo({fields})",
        "options = MakeOptions(",
        f"    nozzle={x.nozzle:g}, bed=({bed}), tolerance={x.tolerance:g}, seed={x.seed},",
        "    motor=motor, servo=servo,",
        ")",
        'export_robot(load_design("trunk.toml"), "made", Request(options=options))',
        "```",
    ]  # fmt: skip
