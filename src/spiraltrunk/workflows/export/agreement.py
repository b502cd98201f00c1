"""Agreement of solids and simulated trunk with the design: relative errors of lengths, gaps, volumes and masses."""

from __future__ import annotations

from typing import Any

import numpy as np

from spiraltrunk.cad.checks.agreement import MeasuredTrunk
from spiraltrunk.design.trunk import TrunkDesign


def compute_agreement(design: TrunkDesign, measured: MeasuredTrunk) -> dict[str, dict[str, Any]]:
    """Errors of the solids and of MuJoCo's compiled trunk against the design: relative, for holes in metres.

    The mass of a solid is its volume times the density that follows from the design's mass, which may have been weighed
    on a print. Where the design's section centres were measured, those of uniform solids are reported and not judged;
    the centre of mass of the whole straight trunk is always judged.
    """
    from spiraltrunk.sim.robot.compiled_trunk import measure_compiled

    simulated = measure_compiled(design)  # MuJoCo's compiled trunk, its holes in the faces.
    density = design.section_mass / (design.solid.volume * design.scale**3)
    mass = density * measured.volume
    rows = {
        "section_length": (measured.section_length, simulated["length"], design.section_length),
        "gap_angle": (measured.gap, None, np.full(design.n_joint, design.joint_limit)),
        "cable_stroke": (measured.stroke, simulated["stroke"], design.cable_stroke),
        "volume": (measured.volume, None, design.solid.volume * design.scale**3),
        "mass": (mass, simulated["mass"], design.section_mass),
        "center": (
            _trunk_center(design, mass, measured.center), _trunk_center(design, mass, simulated["center"]),
            _trunk_center(design, design.section_mass, design.section_center),
        ),
        "section_center": (measured.center, simulated["center"], design.section_center),
        "inertia": (mass[:, None] * measured.gyration, simulated["inertia"], design.section_inertia),
    }  # fmt: skip
    agreement: dict[str, dict[str, Any]] = {
        name: {
            "solids": _off(solids, wanted), "simulation": None if simulation is None else _off(simulation, wanted),
            "allowed": 0.01, "unit": "relative",
        }
        for name, (solids, simulation, wanted) in rows.items()
    }  # fmt: skip
    holes = measured.hole[:-1] if design.gripper is not None else measured.hole
    agreement["holes"] = {
        "solids": float(np.abs(holes - design.hole_position[: len(holes), None]).max()),
        "simulation": simulated["hole"], "allowed": 1e-4, "unit": "m",
    }  # fmt: skip
    for name, row in agreement.items():
        is_measured = name == "section_center" and design.mass.center_fraction is not None
        row["judged"] = "the simulation alone: the design's centre was measured" if is_measured else "both"
        values = [row["simulation"]] if is_measured else [row["solids"], row["simulation"]]
        row["holds"] = all(value is None or value <= row["allowed"] for value in values)
    agreement["density"] = {
        "kg_per_m3": [float(value) for value in density],
        "weighed": design.mass.sections is not None,
    }
    return agreement


def _trunk_center(design: TrunkDesign, mass: np.ndarray, center: Any) -> float:
    """Centre of mass of the whole straight trunk, from the base [m]."""
    starts = np.concatenate([[0.0], np.cumsum(design.section_length)[:-1]])
    return float(np.average(starts + np.asarray(center), weights=mass))


def _off(values: Any, wanted: Any) -> float:
    """Largest relative error [-]."""
    return float(np.abs(np.asarray(values) / wanted - 1).max())
