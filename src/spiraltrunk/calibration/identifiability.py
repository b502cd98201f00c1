"""Parameters that the recordings do not identify, and what to record to identify them."""

from __future__ import annotations

import numpy as np

from spiraltrunk.calibration.calibrate import Calibration, Parameter

CORRELATED = 0.95
"""Correlation above which two parameters are identified together only [-] (ours)."""

_HOW = {
    "stiffness": "a bending take that shuts this joint and holds shapes before it does",
    "mass": "a weighing of sections and gripper (--mass-g), or static loads of single joints (--bench)",
    "center": "a balancing of one section on an edge; recordings confuse it with the mass",
    "friction": "a bending take, with many held shapes on the way",
    "slack": "a bending take that pulls this cable",
    "give": "a bending take to full curl, where tension is large, or a pull of a cable held at its end",
    "hole": "a bending take with markers on every section, or a caliper",
}


def list_unidentified(calibration: Calibration) -> tuple[Parameter, ...]:
    """Parameters whose intervals are hardly narrower than the prior's."""
    return tuple(parameter for parameter in calibration.parameters if not parameter.is_identified)


def list_correlated(calibration: Calibration) -> tuple[tuple[str, str, float], ...]:
    """Pairs of parameters that are identified together only, with their correlation."""
    upper = np.triu(np.abs(calibration.correlation), 1)
    pairs = np.argwhere(upper > CORRELATED)
    return tuple((calibration.names[i], calibration.names[j], float(calibration.correlation[i, j])) for i, j in pairs)


def advise(calibration: Calibration, *, was_weighed: bool) -> tuple[str, ...]:
    """What to record for the parameters that are not identified, one sentence each."""
    names = [parameter.name for parameter in list_unidentified(calibration)]
    advice = []
    if not was_weighed:
        advice.append(
            "stiffness and mass: scaling both leaves every shape as it is, so that recordings identify their ratio "
            f"alone; record {_HOW['mass']}"
        )
    for name in names:
        if name == "mass" and was_weighed:
            advice.append("mass: known from its weighing, or a bench, alone, as shapes identify its ratio to stiffness")
        elif name not in {"mass", "stiffness_over_mass", "stiffness_exponent"}:
            advice.append(f"{name}: record {_HOW[name.split('_')[0]]}")
    return tuple(advice)
