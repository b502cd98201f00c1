"""Agreement of solids and simulated trunk with the design: relative errors of lengths, gaps, volumes and masses."""

from __future__ import annotations

from typing import Any

import numpy as np

from spiraltrunk.cad.checks.agreement import Measured
from spiraltrunk.design.trunk import TrunkDesign


def compute_agreement(design: TrunkDesign, measured: Measured) -> dict[str, dict[str, Any]]:
    """How far the solids and MuJoCo's compiled trunk are from the design: relative errors, for holes in metres.

    Masses of a design may be weighed on a print; then the solids have none of their own, and what their volumes stand
    for is the density that the masses mean. The centre of the whole straight trunk is judged; where the sections' were
    measured, how far those of even solids lie off is told and not judged.
    """
    simulated = _measure_simulation(design)
    volume = design.solid.volume * design.scale**3
    density = design.section_mass / volume
    mass = density * measured.volume
    rows = {
        "section_length": _both(measured.section_length, simulated["length"], design.section_length),
        "gap_angle": (_off(measured.gap, np.full(design.n_joint, design.joint_limit)), None),
        "cable_stroke": _both(np.array(measured.stroke), simulated["stroke"], np.array(design.cable_stroke)),
        "volume": (_off(measured.volume, volume), None),
        "mass": _both(mass, simulated["mass"], design.section_mass),
        "center": (_trunk_off(design, mass, measured.center), _trunk_off(design, mass, simulated["center"])),
        "section_center": _both(measured.center, simulated["center"], design.section_center),
        "inertia": _both(measured.inertia(mass), simulated["inertia"], design.section_inertia),
    }  # fmt: skip
    agreement: dict[str, dict[str, Any]] = {
        name: {"solids": solids, "simulation": simulation, "allowed": 0.01, "unit": "relative"}
        for name, (solids, simulation) in rows.items()
    }
    holes = measured.hole[:-1] if design.gripper is not None else measured.hole
    wanted = design.hole_position[: len(holes), None]
    agreement["holes"] = {
        "solids": float(np.abs(holes - wanted).max()), "simulation": simulated["hole"], "allowed": 1e-4, "unit": "m",
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


def _measure_simulation(design: TrunkDesign) -> dict[str, Any]:
    """The same quantities of MuJoCo's compiled trunk, its holes in the faces."""
    from spiraltrunk.sim.robot.compiled_trunk import measure_compiled

    return measure_compiled(design)


def _both(solids: np.ndarray, simulated: Any, wanted: np.ndarray) -> tuple[float, float]:
    return _off(solids, wanted), _off(np.asarray(simulated), wanted)


def _trunk_off(design: TrunkDesign, mass: np.ndarray, center: Any) -> float:
    """Distance between centres of the whole straight trunk, over that of the design's from the base [-]."""
    starts = np.concatenate([[0.0], np.cumsum(design.section_length)[:-1]])
    own = np.average(starts + np.asarray(center), weights=mass)
    return _off(own, np.average(starts + design.section_center, weights=design.section_mass))


def _off(values: np.ndarray, wanted: np.ndarray) -> float:
    return float(np.abs(np.asarray(values) / wanted - 1).max())
