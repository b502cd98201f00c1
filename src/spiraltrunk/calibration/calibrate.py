"""Calibration: stiffness, mass, friction, slack, holes and give of one trunk from its recorded shapes.

One part of the takes is fitted, the error is told on the other. Beside it stands the error of the design as it was,
by equilibrium and by the paper's forward model, on the same shapes.

Scaling all stiffnesses and all masses together leaves every shape as it is, whatever the cables' lengths and friction,
if winders give as much less: recordings alone tell the ratio. A weighing (`Weighing`) or a bench (`BenchStiffness`)
tells the rest.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import final

import numpy as np
from numpy.typing import ArrayLike

from spiraltrunk.calibration.map_fit import Fit, Task, fit_knobs
from spiraltrunk.calibration.parameters import (
    BenchStiffness,
    Knobs,
    Prior,
    Weighing,
    Winders,
    apply_knobs,
    build_knobs,
    center_fraction,
    learn_from_bench,
)
from spiraltrunk.calibration.predict_states import State, find_states, place_points, play_reference, play_statics
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import ModelError
from spiraltrunk.model.kinematics.measured_shapes import MeasuredShapes
from spiraltrunk.model.statics.pull_sequences import carry_gripper

__all__ = ["BenchStiffness", "Calibration", "Errors", "Parameter", "Prior", "Settings", "Weighing", "calibrate"]

SURE = 1.959963984540054
"""Standard deviations on either side of the mean that hold 95 % of a Gaussian [-]."""

UNTOLD = 0.7
"""Width over the prior's from which a parameter counts as not told by the recordings [-] (ours: half the variance)."""


@final
@dataclass(frozen=True, kw_only=True)
class Settings:
    """How a calibration is made; the defaults are for use."""

    prior: Prior = field(default_factory=Prior)
    """What is known beforehand."""
    weighing: Weighing | None = None
    """What a scale said, if the trunk was weighed."""
    bench: tuple[BenchStiffness, ...] = ()
    """What a bench said of single joints."""
    registration_turn: float = 2e-3
    """Standard deviation of the registration's rotation about each axis [rad] (ours: 1 mm over the trunk's length)."""
    registration_shift: float = 3e-4
    """Of its shift along each axis [m] (ours)."""


@final
@dataclass(frozen=True, kw_only=True)
class Parameter:
    """One fitted number, in SI."""

    name: str
    """Its name, joints and cables counted from 1."""
    unit: str
    """Its unit; "-" for a pure number."""
    before: float
    """What it was in the design, or expected."""
    value: float
    """What it is."""
    low: float
    """Lower end of the 95 % interval."""
    high: float
    """Upper end."""
    width_ratio: float
    """Width over the prior's: near 1 the recordings say nothing [-]."""

    @property
    def is_told(self) -> bool:
        """Whether the recordings tell it."""
        return self.width_ratio < UNTOLD


@final
@dataclass(frozen=True, kw_only=True)
class Errors:
    """Root mean square distance of the measured points of each shape from a model's, not a number where it has none."""

    index: np.ndarray
    """Which of the measured shapes, shape (n,) [-]."""
    calibrated: np.ndarray
    """By equilibrium, calibrated, shape (n,) [m]."""
    uncalibrated: np.ndarray
    """By equilibrium of the design as it was, without friction told of it, shape (n,) [m]."""
    reference: np.ndarray
    """By the paper's forward model of the design as it was, shape (n,) [m]."""


@final
@dataclass(frozen=True, kw_only=True)
class Calibration:
    """What the recordings say of a trunk."""

    design: TrunkDesign
    """The design with what was fitted, but slack and give, which are no part of it."""
    slack: np.ndarray
    """Cable that each winder takes in before it pulls, shape (n_cable,) [m]."""
    give: float
    """What each winder with its cable gives per tension [m/N]."""
    parameters: tuple[Parameter, ...]
    """All fitted numbers, then the ratio of stiffness to mass and the exponent of the stiffness law."""
    correlation: np.ndarray
    """Of the fitted knobs, in the order of `names`, shape (n_knob, n_knob) [-]."""
    names: tuple[str, ...]
    """Names of the knobs."""
    fit: Fit
    """Knobs, covariance and scatter as they were fitted."""
    fitted: Errors
    """Errors on the shapes that were fitted."""
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
    tell: Callable[[str, int, int], None] | None = None,
) -> Calibration:
    """Fit a design to the shapes of ``is_fitted`` and judge it on the others.

    Args:
        design: the trunk as it was built; its stiffness law, masses and holes are where the search begins.
        shapes: what was recorded.
        is_fitted: which shapes are fitted, shape (n,) [bool]; the others are held out.
        settings: how.
        tell: called with what is being done, how often it was and how often it will be at most.

    Raises:
        ModelError: where shapes and design do not fit, or no point was seen in what is to be fitted.
    """
    settings = Settings() if settings is None else settings
    chosen = np.asarray(is_fitted)
    _check(design, shapes, chosen)
    trunk = carry_gripper(design)
    known = find_states(shapes)
    knobs = learn_from_bench(design, build_knobs(design, settings.prior, settings.weighing), settings.bench)
    task = _build_task(trunk, shapes, chosen, (known.states, known.of_shape))
    fit = fit_knobs(task, knobs, (settings.registration_turn, settings.registration_shift), tell)
    return _tell_all(design, (shapes, chosen), (known.states, known.of_shape), (fit, knobs))


def compute_rmse(predicted: np.ndarray, measured: np.ndarray) -> np.ndarray:
    """Root mean square distance over the seen points of each shape, shapes (n, n_section, 3) -> (n,) [m]."""
    square = ((predicted - measured) ** 2).sum(axis=-1)
    seen = np.isfinite(measured).all(axis=-1)
    count = seen.sum(axis=-1)
    total = np.where(seen, square, 0.0).sum(axis=-1)
    return np.sqrt(np.where(count > 0, total / np.maximum(count, 1), np.nan))


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


def _build_task(
    trunk: TrunkDesign,
    shapes: MeasuredShapes,
    chosen: np.ndarray,
    known: tuple[tuple[State, ...], np.ndarray],
) -> Task:
    """Mean of the repeats of every state that is fitted, and the states that lead there."""
    states, of_shape = known
    count = np.zeros((len(states), trunk.n_section), int)
    total = np.zeros((len(states), trunk.n_section, 3))
    seen = np.isfinite(shapes.points).all(axis=-1)
    for i in np.flatnonzero(chosen):
        count[of_shape[i]] += seen[i]
        total[of_shape[i]] += np.where(seen[i][:, None], shapes.points[i], 0.0)
    needed = {int(s) for s in of_shape[chosen]}
    for s in range(len(states) - 1, -1, -1):  # A state stands before those that go on from it.
        if s in needed and states[s].before >= 0:
            needed.add(states[s].before)
    kept = sorted(needed)
    place = {s: i for i, s in enumerate(kept)}
    own = tuple(_renumber(states[s], place) for s in kept)
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = total[kept] / count[kept][..., None]
    return Task(
        design=trunk, states=own, seat=np.asarray(shapes.seat, float), measured=mean, count=count[kept],
    )  # fmt: skip


def _renumber(state: State, place: dict[int, int]) -> State:
    before = -1 if state.before < 0 else place[state.before]
    return State(theta_0=state.theta_0, pull=state.pull, before=before, kind=state.kind, chain=state.chain)


def _tell_all(
    design: TrunkDesign,
    recorded: tuple[MeasuredShapes, np.ndarray],
    known: tuple[tuple[State, ...], np.ndarray],
    found: tuple[Fit, Knobs],
) -> Calibration:
    (shapes, chosen), (states, of_shape), (fit, knobs) = recorded, known, found
    trunk = carry_gripper(design)
    turned, winders = apply_knobs(trunk, fit.knobs)
    played = play_statics(turned, states, winders)
    plain = play_statics(trunk, states, Winders(slack=np.zeros(design.n_cable)))
    three = (played.points, plain.points, play_reference(trunk, states))
    placed = [place_points(trunk, model, shapes.seat)[of_shape] for model in three]
    rmse = [compute_rmse(model, shapes.points) for model in placed]
    errors = [
        Errors(
            index=np.flatnonzero(part), calibrated=rmse[0][part], uncalibrated=rmse[1][part], reference=rmse[2][part]
        )
        for part in (chosen, ~chosen)
    ]
    spread = np.sqrt(np.diag(fit.covariance))
    return Calibration(
        design=apply_knobs(design, fit.knobs)[0], slack=winders.slack, give=winders.give,
        parameters=describe(design, fit, knobs),
        correlation=fit.covariance / np.outer(spread, spread), names=knobs.names, fit=fit, fitted=errors[0],
        held_out=errors[1], unsolved=int(played.has_failed[of_shape].sum()),
    )  # fmt: skip


def describe(design: TrunkDesign, fit: Fit, knobs: Knobs) -> tuple[Parameter, ...]:
    """The knobs in SI with their intervals, then two numbers that follow from them.

    These are the stiffness of joint 1 over the mass, which shapes tell without a scale, and the exponent n of the law
    K ~ k_p^(n (i - 1)) that lies nearest to all joints, 3 by E I / L.
    """
    joints, size = design.n_joint, len(fit.knobs)
    out = [_describe(knobs.names[k], design, (np.eye(size)[k], k), (fit, knobs)) for k in range(size)]
    ratio = np.zeros(size)
    ratio[:joints], ratio[joints] = 1 / joints, -1.0
    along = np.log(design.scale[:-1])
    slope = np.zeros(size)
    slope[:joints] = (along - along.mean()) / ((along - along.mean()) ** 2).sum()
    out.append(_describe("stiffness_over_mass", design, (ratio, -1), (fit, knobs)))
    out.append(_describe("stiffness_exponent", design, (slope, -1), (fit, knobs)))
    return tuple(out)


def _describe(name: str, design: TrunkDesign, row: tuple[np.ndarray, int], found: tuple[Fit, Knobs]) -> Parameter:
    """One linear combination of the knobs, in SI."""
    (weights, knob), (fit, knobs) = row, found
    middle, spread = float(weights @ fit.knobs), float(np.sqrt(weights @ fit.covariance @ weights))
    before = float(weights @ knobs.mean)
    wide = float(np.sqrt(weights @ knobs.covariance @ weights))
    unit, scale, origin = _unit_of(name, design, knob)
    low, high = middle - SURE * spread, middle + SURE * spread
    if name in ("friction", "give"):
        low = max(low, 0.0)
    numbers = (before, middle, low, high)
    if scale > 0:
        told = [scale * float(np.exp(number)) for number in numbers]
    else:
        told = [origin + number for number in numbers]
    return Parameter(
        name=name, unit=unit, before=told[0], value=told[1], low=told[2], high=told[3], width_ratio=spread / wide
    )


def _unit_of(name: str, design: TrunkDesign, knob: int) -> tuple[str, float, float]:
    """Unit of a number, what its exponential is multiplied with (0 for none), and what it is added to."""
    if name == "stiffness_over_mass":
        level = float(np.exp(np.log(design.joint_stiffness).mean()))
        return "N m/rad/kg", level / design.total_mass, 0.0
    if name == "stiffness_exponent":
        along, law = np.log(design.scale[:-1]), np.log(design.joint_stiffness)
        return "-", 0.0, float(np.polyfit(along, law, 1)[0])
    if name.startswith("stiffness_"):
        return "N m/rad", float(design.joint_stiffness[knob]), 0.0
    if name == "mass":
        return "kg", design.total_mass, 0.0
    origin = {"center": center_fraction(design), "hole": design.cable.hole_fraction}.get(name, 0.0)
    return ("m/N" if name == "give" else "m" if name.startswith("slack_") else "-"), 0.0, origin
