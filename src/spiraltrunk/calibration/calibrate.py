"""Calibration: stiffness, mass, friction, slack, holes and winder compliance of one trunk from its recorded shapes.

Some takes are fitted, and the error is evaluated on the others, beside that of the design as it was, by equilibrium and
by the paper's forward model.

Shapes identify the ratio of stiffness to mass only: scaling all stiffnesses and all masses together leaves every shape
as it is, whatever the cables' lengths and friction, where the compliance of the winders falls by the same factor. A
weighing (`Weighing`) or a bench (`BenchStiffness`) identifies the rest.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import final

import numpy as np
from numpy.typing import ArrayLike

from spiraltrunk.calibration.fit_problem import FitProblem
from spiraltrunk.calibration.map_fit import MapEstimate, estimate_map
from spiraltrunk.calibration.parameters import (
    BenchStiffness,
    Gaussian,
    Prior,
    Weighing,
    Winders,
    apply_parameters,
    build_prior,
    center_fraction,
)
from spiraltrunk.calibration.predict_states import (
    State,
    find_states,
    place_markers,
    predict_reference,
    predict_statics,
    select_states,
)
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import ModelError
from spiraltrunk.field_docs import explain_fields
from spiraltrunk.files.results import Progress, ignore_progress
from spiraltrunk.model.kinematics.measured_shapes import MeasuredShapes
from spiraltrunk.model.statics.pull_sequences import carry_gripper

__all__ = ["BenchStiffness", "Calibration", "Errors", "Parameter", "Prior", "Settings", "Weighing", "calibrate"]

Z_95 = 1.959963984540054
"""Standard deviations on either side of the mean that hold 95 % of a normal distribution [-]."""

IDENTIFIED = 0.7
"""Width over the prior's below which a parameter counts as identified [-] (ours: half the variance)."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class Settings:
    """Prior knowledge and tolerances of a calibration."""

    prior: Prior = field(default_factory=Prior)
    """What is known beforehand."""
    weighing: Weighing | None = None
    """The weighing, if the trunk was weighed."""
    bench: tuple[BenchStiffness, ...] = ()
    """Stiffness of single joints from a bench."""
    registration_turn: float = 2e-3
    """Standard deviation of the registration's rotation about each axis [rad] (ours: 1 mm over the trunk's length)."""
    registration_shift: float = 3e-4
    """Of its shift along each axis [m] (ours)."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class Parameter:
    """One fitted number, in SI."""

    name: str
    """Its name, joints and cables counted from 1."""
    unit: str
    """Its unit; "-" for a pure number."""
    before: float
    """What it was in the design, or the prior's mean."""
    value: float
    """MAP estimate."""
    low: float
    """Lower end of the 95 % interval."""
    high: float
    """Upper end."""
    width_ratio: float
    """Width over the prior's; near 1 the recordings do not identify it [-]."""

    @property
    def is_identified(self) -> bool:
        """Whether the recordings identify it."""
        return self.width_ratio < IDENTIFIED


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class Errors:
    """Root mean square distance of the measured points of each shape from a model's, not a number where it has none."""

    index: np.ndarray
    """Which of the measured shapes, shape (n,) [-]."""
    calibrated: np.ndarray
    """By equilibrium, calibrated, shape (n,) [m]."""
    uncalibrated: np.ndarray
    """By equilibrium of the design as it was, shape (n,) [m]."""
    reference: np.ndarray
    """By the paper's forward model of the design as it was, shape (n,) [m]."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class RunMisfit:
    """How well the calibrated model expresses the fitted takes of one run."""

    take: str
    """Its takes, their names joined by "+"."""
    kind: str
    """What was pulled, of `measured_shapes.KINDS`."""
    n_shape: int
    """Distinct shapes [-]."""
    rms: float
    """Root mean square distance of the measured from the predicted points [m]."""
    registered_rms: float
    """The same without the part that an error of the registration explains [m]."""
    discrepancy: float
    """Standard deviation of the model's error that the fit allowed for, at the tip of the straight trunk [m]."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class Calibration:
    """A calibrated trunk."""

    design: TrunkDesign
    """The design with the fitted parameters, without those of the winders."""
    winders: Winders
    """Slack and compliance of the winders, which are no part of a design."""
    parameters: tuple[Parameter, ...]
    """All fitted numbers, then the ratio of stiffness to mass and the exponent of the stiffness law."""
    correlation: np.ndarray
    """Of the parameter vector, in the order of `names`, shape (n_parameter, n_parameter) [-]."""
    names: tuple[str, ...]
    """Names of the parameter vector."""
    fit: MapEstimate
    """Parameter vector, covariance and noise model."""
    fitted: Errors
    """Errors on the shapes that were fitted."""
    misfits: tuple[RunMisfit, ...]
    """Misfit of each run that was fitted."""
    held_out: Errors
    """Errors on the others."""
    unsolved: int
    """Shapes whose equilibrium did not converge; the best found stands for them [-]."""


def calibrate(
    design: TrunkDesign,
    shapes: MeasuredShapes,
    is_fitted: ArrayLike,
    settings: Settings | None = None,
    *,
    progress: Progress = ignore_progress,
) -> Calibration:
    """Fit a design to the shapes of ``is_fitted`` and evaluate it on the others.

    Args:
        design: the trunk as it was built; its stiffness law, masses and holes are the prior's mean.
        shapes: what was recorded.
        is_fitted: which shapes are fitted, shape (n,) [bool]; the others are held out.
        settings: prior knowledge and tolerances.
        progress: called with the step, how many of them are done, and at most how many there are.

    Raises:
        ModelError: where shapes and design do not fit, or no point was seen in what is to be fitted.
    """
    settings, chosen = settings or Settings(), np.asarray(is_fitted)
    _check(design, shapes, chosen)
    trunk = carry_gripper(design)
    states, of_shape = find_states(shapes)
    prior = build_prior(design, settings.prior, settings.weighing, settings.bench)
    problem = _build_problem(trunk, shapes, chosen, (states, of_shape))
    fit = estimate_map(problem, prior, (settings.registration_turn, settings.registration_shift), progress)
    calibrated, winders = apply_parameters(trunk, fit.values)
    equilibria = predict_statics(calibrated, states, winders)
    plain = predict_statics(trunk, states, Winders(slack=np.zeros(design.n_cable)))
    rmse = [
        compute_rmse(place_markers(trunk, ends, shapes.marker_offset)[of_shape], shapes.points)
        for ends in (equilibria.points, plain.points, predict_reference(trunk, states))
    ]
    fitted, held_out = (
        Errors(index=np.flatnonzero(own), calibrated=rmse[0][own], uncalibrated=rmse[1][own], reference=rmse[2][own])
        for own in (chosen, ~chosen)
    )
    spread = np.sqrt(np.diag(fit.covariance))
    return Calibration(
        design=apply_parameters(design, fit.values)[0], winders=winders, parameters=describe(design, fit, prior),
        correlation=fit.covariance / np.outer(spread, spread), names=prior.names, fit=fit, fitted=fitted,
        held_out=held_out, misfits=_name_misfits(fit, shapes, chosen, (states, of_shape)),
        unsolved=int(equilibria.has_failed[of_shape].sum()),
    )  # fmt: skip


def compute_rmse(predicted: np.ndarray, measured: np.ndarray) -> np.ndarray:
    """Root mean square distance over the seen points of each shape, shapes (n, n_section, 3) -> (n,) [m]."""
    square = ((predicted - measured) ** 2).sum(axis=-1)
    seen = np.isfinite(measured).all(axis=-1)
    count = seen.sum(axis=-1)
    total = np.where(seen, square, 0.0).sum(axis=-1)
    return np.sqrt(np.where(count > 0, total / np.maximum(count, 1), np.nan))


def _name_misfits(
    fit: MapEstimate, shapes: MeasuredShapes, chosen: np.ndarray, known: tuple[tuple[State, ...], np.ndarray]
) -> tuple[RunMisfit, ...]:
    """Misfits of the chains by the takes that were fitted."""
    states, of_shape = known
    chain = np.array([state.chain for state in states])[of_shape]
    out = []
    for one in fit.misfits:
        own = np.flatnonzero(chosen & (chain == one.chain))
        takes = dict.fromkeys(shapes.take[i] for i in own)
        out.append(
            RunMisfit(
                take="+".join(takes), kind=shapes.kind[own[0]], n_shape=len(np.unique(of_shape[own])), rms=one.rms,
                registered_rms=one.registered_rms, discrepancy=one.noise_model.discrepancy,
            )
        )  # fmt: skip
    return tuple(out)


def _check(design: TrunkDesign, shapes: MeasuredShapes, chosen: np.ndarray) -> None:
    count = len(shapes.kind)
    if chosen.shape != (count,) or chosen.dtype != bool:
        raise ModelError(f"is_fitted has shape {chosen.shape} and holds {chosen.dtype}; allowed: {count} booleans")
    if not chosen.any():
        raise ModelError("no shape is fitted; allowed: at least one")
    expected = (count, design.n_section, 3), (count, design.n_cable)
    given = shapes.points.shape, shapes.pull.shape
    if given != expected:
        raise ModelError(f"points and pull have the shapes {given}; allowed for this design: {expected}")


def _build_problem(
    trunk: TrunkDesign, shapes: MeasuredShapes, chosen: np.ndarray, known: tuple[tuple[State, ...], np.ndarray]
) -> FitProblem:
    """Least-squares problem: mean measured points of each fitted state, with the states on the loading path to it."""
    states, of_shape = known
    seen = np.isfinite(shapes.points).all(axis=-1)
    count = np.zeros((len(states), trunk.n_section), int)
    total = np.zeros((len(states), trunk.n_section, 3))
    np.add.at(count, of_shape[chosen], seen[chosen])
    np.add.at(total, of_shape[chosen], np.where(seen[..., None], shapes.points, 0.0)[chosen])
    needed = set(of_shape[chosen].tolist())
    for s in range(len(states) - 1, -1, -1):  # A state stands before those that go on from it.
        if s in needed and states[s].before >= 0:
            needed.add(states[s].before)
    kept = sorted(needed)
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = total[kept] / count[kept][..., None]
    return FitProblem(
        design=trunk, states=select_states(states, kept), marker_offset=np.asarray(shapes.marker_offset, float),
        measured=mean, count=count[kept],
    )  # fmt: skip


def describe(design: TrunkDesign, fit: MapEstimate, prior: Gaussian) -> tuple[Parameter, ...]:
    """The parameters in SI with their intervals, and two linear combinations of them.

    These are the stiffness of joint 1 over the mass, which shapes identify without a scale, and the exponent n of the
    law K ~ k_p^(n (i - 1)) that lies nearest to all joints, 3 by E I / L.
    """
    joints, size = design.n_joint, len(fit.values)
    ratio, exponent, along = np.zeros(size), np.zeros(size), np.log(design.scale[:-1])
    ratio[:joints], ratio[joints] = 1 / joints, -1.0
    exponent[:joints] = (along - along.mean()) / ((along - along.mean()) ** 2).sum()
    rows = dict(zip((*prior.names, "stiffness_over_mass", "stiffness_exponent"), [*np.eye(size), ratio, exponent],
                    strict=True))  # fmt: skip
    return tuple(_describe(name, row, design, fit, prior) for name, row in rows.items())


def _describe(name: str, row: np.ndarray, design: TrunkDesign, fit: MapEstimate, prior: Gaussian) -> Parameter:
    """A linear combination of the parameter vector, in SI."""
    unit, factor, origin = _find_scale(design, name)
    middle, spread = float(row @ fit.values), float(np.sqrt(row @ fit.covariance @ row))
    low, high = middle - Z_95 * spread, middle + Z_95 * spread
    if name in ("friction", "give"):
        low = max(low, 0.0)
    before, value, low, high = (
        origin + number if factor is None else factor * float(np.exp(number))
        for number in (float(row @ prior.mean), middle, low, high)
    )
    return Parameter(
        name=name, unit=unit, before=before, value=value, low=low, high=high,
        width_ratio=spread / float(np.sqrt(row @ prior.covariance @ row)),
    )  # fmt: skip


def _find_scale(design: TrunkDesign, name: str) -> tuple[str, float | None, float]:
    """Unit in SI, and what the number's exponential is multiplied by, or None and what the number is added to."""
    stiffness, law = design.joint_stiffness, np.log(design.joint_stiffness)
    if name == "stiffness_over_mass":
        return "N m/rad/kg", float(np.exp(law.mean())) / design.total_mass, 0.0
    if name == "stiffness_exponent":
        return "-", None, float(np.polyfit(np.log(design.scale[:-1]), law, 1)[0])
    if name.startswith("stiffness_"):
        return "N m/rad", float(stiffness[int(name.removeprefix("stiffness_")) - 1]), 0.0
    if name == "mass":
        return "kg", design.total_mass, 0.0
    if name.startswith("slack_"):
        return "m", None, 0.0
    origins = {"center": center_fraction(design), "hole": design.cable.hole_fraction}
    return "m/N" if name == "give" else "-", None, origins.get(name, 0.0)
