"""Parameters that the recordings do not identify, and what to record to identify them."""

from __future__ import annotations

import numpy as np

from spiraltrunk.calibration.calibrate import Calibration, Parameter, RunMisfit

CORRELATED = 0.95
"""Correlation above which two parameters are identified together only [-] (ours)."""

MISFITTED = 3.0
"""RMS of a run over the median of the others above which the run is misfitted [-] (ours)."""

_LEAST_MISFIT = 2e-3
"""RMS over the trunk's length below which no run is misfitted [-] (ours: 1 mm)."""

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


def list_misfitted(calibration: Calibration) -> tuple[RunMisfit, ...]:
    """Runs whose misfit is out of proportion to that of the other fitted runs: the model does not express them."""
    rms = [run.registered_rms for run in calibration.misfits]
    least = _LEAST_MISFIT * calibration.design.length
    return tuple(
        run
        for i, run in enumerate(calibration.misfits)
        if len(rms) > 1 and rms[i] > max(MISFITTED * float(np.median([*rms[:i], *rms[i + 1 :]])), least)
    )


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
