"""The plan of a session: what to do, line by line, and the winders' lengths as a table for the motors."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Sequence

import numpy as np

from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.mocap.protocol.protocol import Protocol, Run
from spiraltrunk.mocap.protocol.schedule import Plan
from spiraltrunk.model.kinematics.measured_shapes import compute_marker_offset

_TOLD = 5e-6
"""Half of the last digit in the tables [m]."""

_DOES = {
    "rest": "all cables slack",
    "bend-dorsal": "cable 1 pulled in step by step, the others let out as far as they need",
    "bend-ventral": "the other cables pulled in step by step, cable 1 let out as far as it needs",
    "twist": "cable 1 pulled in and held, then cable 2 pulled in step by step, cable 3 let out as far as it needs",
}


def format_plan(design: TrunkDesign, protocol: Protocol, plans: Sequence[Plan]) -> str:
    """A list to print and tick off, in Markdown."""
    hold = protocol.still.hold
    lines = [f"# Session {protocol.name}, trunk {design.name}", "", *_prepare(design, protocol)]
    for plan in plans:
        run = plan.run
        lines += ["", f"## {run.name}: {run.kind}, {_tell_base(run)}", ""]
        lines.append(f"Set the base to {_tell_base(run)}; {_DOES[run.kind]}.")
        if run.kind != "rest":
            lines += ["", *_table(design, plan)]
        for take in range(1, run.takes + 1):
            what = f"hold {'the shape' if run.n_shape == 1 else f'each of the {run.n_shape} shapes'} still for"
            export = f"export as `{run.name}_{take}.csv`"
            lines += ["", f"- [ ] take {take}: start slack, record, {what} {2 * hold:g} s or more, stop, {export}"]
    return "\n".join(lines) + "\n"


def _prepare(design: TrunkDesign, protocol: Protocol) -> list[str]:
    along, radius = compute_marker_offset(design), design.section_radius
    return [
        "- [ ] markers: three on the lower edge of each section, 120 deg apart, the first dorsal (at cable 1), counted "
        f"as the cables; from {1e3 * along[0]:.1f} mm beyond the proximal joint and {2e3 * radius[0]:.1f} mm across at "
        f"section 1 to {1e3 * along[-1]:.1f} and {2e3 * radius[-1]:.1f} mm at section {design.n_section}; 15 sections, "
        "or any three or more",
        "- [ ] Motive: a rigid body a section, section_01 at the base, and one called "
        f"{protocol.base} at the trunk's base: origin at the beginning of section 1, x along the base axis, y dorsal",
        "- [ ] Motive: calibrate, level the ground plane, write down the axis convention of the export "
        f"(now {protocol.axes or 'not told'})",
        "- [ ] slack: wrap the trunk fully, measure what each cable still gives (L_slack), write it to slack_mm (now "
        f"{', '.join(f'{1e3 * value:g}' for value in protocol.slack)} mm)",
        "- [ ] winders: pull at 5 mm/s or less, and start and stop softly: a swing shakes sticking cables loose",
    ]


def _tell_base(run: Run) -> str:
    tilt = 90.0 - math.degrees(run.theta_0)
    return f"tilt {tilt:g} deg from hanging (theta_0 {math.degrees(run.theta_0):g} deg)"


def _table(design: TrunkDesign, plan: Plan) -> list[str]:
    """Each shape with what each winder has pulled in by since the straight trunk."""
    cables = [f"cable {i + 1} [mm]" for i in range(design.n_cable)]
    rows = [["shape", "step [mm]", *cables], ["---"] * (design.n_cable + 2)]
    for i, (amount, told) in enumerate(zip(plan.amount, plan.told, strict=True)):
        rows.append([str(i + 1), f"{1e3 * amount:g}", *(f"{_round(1e3 * value):.2f}" for value in told)])
    told = "Pulled in since the straight trunk, slack made up for; negative is let out:"
    return [told, "", *("| " + " | ".join(row) + " |" for row in rows), *_explain(design, plan)]


def _explain(design: TrunkDesign, plan: Plan) -> list[str]:
    """Why cable 1 is not pulled in by the step itself: the model's measures, the rest, and full curl."""
    if plan.run.kind != "bend-dorsal":
        return []
    said = [
        "Cable 1 is measured on the model's shapes: the rounded measures of its authors' code, which it keeps, make "
        "100 mm come out as 100.01."
    ]
    if abs(plan.change[0, 0]) > _TOLD:
        said.append("Steps count from the rest, shape 1, and not from the straight trunk.")
    if plan.amount[-1] + plan.change[0, 0] > design.cable_stroke + _TOLD:
        stroke = f"{1e3 * design.cable_stroke:.2f} mm"
        said.append(f"Full curl shuts every gap and takes {stroke} of cable 1, slack apart: there the last step ends.")
    return ["", " ".join(said)]


def format_schedule(design: TrunkDesign, plans: Sequence[Plan]) -> str:
    """What the winders are told, shape by shape, as CSV: lengths pulled in since the straight trunk [m].

    A cable at rest is slack: its length is blank, and the winder pays out freely.
    """
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["run", "shape", "theta0_deg", *(f"cable_{i + 1}_m" for i in range(design.n_cable))])
    for plan in plans:
        for i, told in enumerate(plan.told):
            cells = [""] * design.n_cable if plan.run.kind == "rest" else [f"{_round(value, 6):.6f}" for value in told]
            writer.writerow([plan.run.name, i + 1, f"{math.degrees(plan.run.theta_0):g}", *cells])
    return text.getvalue()


def _round(value: float | np.floating, digits: int = 2) -> float:
    """Rounded, without a minus before zero."""
    return round(float(value), digits) + 0.0
