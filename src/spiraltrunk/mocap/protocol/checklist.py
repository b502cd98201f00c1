"""Checklist of a session in Markdown, and the winders' lengths as CSV."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Sequence

from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.mocap.protocol.protocol import Protocol, Run
from spiraltrunk.mocap.protocol.schedule import Schedule
from spiraltrunk.model.kinematics.measured_shapes import compute_marker_offset

_ROUNDING = 5e-6
"""Half of the last digit in the tables [m]."""

_ACTIONS = {
    "rest": "all cables slack",
    "bend-dorsal": "cable 1 pulled in step by step, the others let out as far as they need",
    "bend-ventral": "the ventral cables pulled in step by step, the others let out as far as they need",
    "twist": "cable 1 pulled in and held, then cable 2 pulled in step by step, cable 3 let out as far as it needs",
}


def format_checklist(design: TrunkDesign, protocol: Protocol, schedules: Sequence[Schedule]) -> str:
    """A list to print and tick off, in Markdown."""
    lines = [f"# Session {protocol.name}, trunk {design.name}", "", *_list_preparations(design, protocol)]
    for schedule in schedules:
        run, base = schedule.run, _format_base(schedule.run)
        lines += ["", f"## {run.name}: {run.kind}, {base}", "", f"Set the base to {base}; {_ACTIONS[run.kind]}."]
        if run.kind != "rest":
            lines += ["", *_build_table(design, schedule)]
        for take in range(1, run.takes + 1):
            what = f"hold {'the shape' if run.n_shape == 1 else f'each of the {run.n_shape} shapes'} still for"
            hold, export = f"{what} {2 * protocol.still.hold:g} s or more", f"export as `{run.name}_{take}.csv`"
            lines += ["", f"- [ ] take {take}: start slack, record, {hold}, stop, {export}"]
    return "\n".join(lines) + "\n"


def _list_preparations(design: TrunkDesign, protocol: Protocol) -> list[str]:
    along, radius = compute_marker_offset(design), design.section_radius
    return [
        "- [ ] markers: three on the lower edge of each section, 120 deg apart, the first dorsal (at cable 1), counted "
        f"as the cables; from {1e3 * along[0]:.1f} mm beyond the proximal joint and {2e3 * radius[0]:.1f} mm across at "
        f"section 1 to {1e3 * along[-1]:.1f} and {2e3 * radius[-1]:.1f} mm at section {design.n_section}; 15 sections, "
        "or any three or more",
        "- [ ] Motive: a rigid body a section, section_01 at the base, and one called "
        f"{protocol.base} at the trunk's base: origin at the beginning of section 1, x along the base axis, y dorsal",
        "- [ ] Motive: calibrate, level the ground plane, write down the axis convention of the export "
        f"(now {protocol.axes or 'not given'})",
        "- [ ] slack: wrap the trunk fully, measure the residual slack of each cable (L_slack), write it to slack_mm "
        f"(now {', '.join(f'{1e3 * value:g}' for value in protocol.slack)} mm)",
        "- [ ] winders: pull at 5 mm/s or less, and start and stop softly: oscillations release sticking cables",
    ]


def _format_base(run: Run) -> str:
    theta_0 = math.degrees(run.theta_0)
    return f"tilt {90.0 - theta_0:g} deg from hanging (theta_0 {theta_0:g} deg)"


def _build_table(design: TrunkDesign, schedule: Schedule) -> list[str]:
    """Commanded lengths of each shape, and remarks."""
    rows = [
        ["shape", "step [mm]", *(f"cable {i + 1} [mm]" for i in range(design.n_cable))],
        ["---"] * (design.n_cable + 2),
        *(
            [str(i + 1), f"{1e3 * amount:g}", *(f"{1e3 * value:z.2f}" for value in commanded)]
            for i, (amount, commanded) in enumerate(zip(schedule.amount, schedule.commanded, strict=True))
        ),
    ]
    head = "Pulled in since the straight trunk, with slack compensation; negative is let out:"
    return [head, "", *("| " + " | ".join(row) + " |" for row in rows), *_list_remarks(design, schedule)]


def _list_remarks(design: TrunkDesign, schedule: Schedule) -> list[str]:
    """Why cable 1 is not pulled in by the step itself: rounding in the model, the shape at rest, and full curl."""
    if schedule.run.kind != "bend-dorsal":
        return []
    remarks = [
        "Cable 1 is measured on the model's shapes: the rounded dimensions of its authors' code, which it keeps, make "
        "100 mm come out as 100.01."
    ]
    if abs(schedule.change[0, 0]) > _ROUNDING:
        remarks.append("Steps count from the rest, shape 1, and not from the straight trunk.")
    if schedule.amount[-1] + schedule.change[0, 0] > design.cable_stroke + _ROUNDING:
        stroke = f"{1e3 * design.cable_stroke:.2f} mm"
        remarks.append(
            f"Full curl closes every gap and takes {stroke} of cable 1 without slack: the last step ends there."
        )
    return ["", " ".join(remarks)]


def format_schedule(design: TrunkDesign, schedules: Sequence[Schedule]) -> str:
    """The winders' commands, shape by shape, as CSV: lengths pulled in since the straight trunk [m].

    At rest the cells are blank: the winders pay out freely.
    """
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["run", "shape", "theta0_deg", *(f"cable_{i + 1}_m" for i in range(design.n_cable))])
    for schedule in schedules:
        is_rest, theta_0 = schedule.run.kind == "rest", f"{math.degrees(schedule.run.theta_0):g}"
        for i, commanded in enumerate(schedule.commanded):
            cells = ["" if is_rest else f"{value:z.6f}" for value in commanded]
            writer.writerow([schedule.run.name, i + 1, theta_0, *cells])
    return text.getvalue()
