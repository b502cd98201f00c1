"""What the recordings could not tell of a trunk, and what to record to tell it."""

from __future__ import annotations

import numpy as np

from spiraltrunk.calibration.calibrate import Calibration, Parameter

TIED = 0.95
"""Correlation of two knobs from which they are told together alone [-] (ours)."""

_HOW = {
    "stiffness": "a bending take that shuts this joint and holds shapes before it does",
    "mass": "a weighing of sections and gripper (--mass-g), or static loads of single joints (--bench)",
    "center": "a balancing of one section on an edge; recordings confuse it with the mass",
    "friction": "a bending take, with many held shapes on the way",
    "slack": "a bending take that pulls this cable",
    "give": "a bending take to full curl, where tension is large, or a pull of a cable held at its end",
    "hole": "a bending take with markers on every section, or a caliper",
}


def find_untold(calibration: Calibration) -> tuple[Parameter, ...]:
    """Parameters that are hardly better known than before."""
    return tuple(parameter for parameter in calibration.parameters if not parameter.is_told)


def find_tied(calibration: Calibration) -> tuple[tuple[str, str, float], ...]:
    """Pairs of knobs that the recordings tell together alone, with their correlation."""
    upper = np.triu(np.abs(calibration.correlation), 1)
    pairs = np.argwhere(upper > TIED)
    return tuple((calibration.names[i], calibration.names[j], float(calibration.correlation[i, j])) for i, j in pairs)


def advise(calibration: Calibration, *, was_weighed: bool) -> tuple[str, ...]:
    """What to record, in words, for what is not told."""
    names = [parameter.name for parameter in find_untold(calibration)]
    words = []
    if not was_weighed:
        words.append(
            "stiffness and mass: scaling both leaves every shape as it is, so that their ratio alone is told; "
            f"record {_HOW['mass']}"
        )
        names = [name for name in names if name != "mass"]
    for name in names:
        kind = name.split("_")[0]
        if name == "mass":
            words.append("mass: known by its weighing, or a bench, alone, as shapes tell its ratio to stiffness")
        elif kind in _HOW and name not in {"stiffness_over_mass", "stiffness_exponent"}:
            words.append(f"{name}: record {_HOW[kind]}")
    return tuple(words)
