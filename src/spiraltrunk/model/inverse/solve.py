"""Inverse model: cable tensions for a tip position, a tip pose, a whole shape or a curl round a circle.

The forward model is the static equilibrium. Without friction the unknowns are the cable tensions from 0 to the design's
largest: any such tensions have an equilibrium, which a set of cable lengths need not have. The solution holds the
tensions and the cable lengths of the same shape. Starts with low tension are preferred. Three cables give three degrees
of freedom: a tip position is met exactly, a direction, a shape or a circle in least squares.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, final

import numpy as np
from numpy.typing import ArrayLike

from spiraltrunk.checks import Range, broadcast_batches, check_count, check_type, read_numbers
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import ModelError
from spiraltrunk.field_docs import explain_fields
from spiraltrunk.model.identity_cache import IdentityKey
from spiraltrunk.model.inverse.friction import read_friction, solve_with_friction
from spiraltrunk.model.inverse.kernels.target_residual import Targets, gap_rows
from spiraltrunk.model.inverse.multistart import InverseOptions, read_load_cases, solve_targets
from spiraltrunk.model.inverse.path_search import Goal
from spiraltrunk.model.inverse.start_table import build_no_targets, section_axes
from spiraltrunk.model.kinematics.enclosure import first_wrapped, snug_bend
from spiraltrunk.model.kinematics.shape import Shape, Status, describe_batch, describe_range
from spiraltrunk.model.statics.loading_path import LoadingPath
from spiraltrunk.model.statics.loads import Loads

__all__ = ["InverseOptions", "InverseSolution", "curl", "follow", "solve"]

_DEEP = 30.0
"""Weight of a section's penetration of the circle over that of a gap [-]."""

_PLACES = Range(least=-1e4, most=1e4)
"""Coordinates of a target [m]."""

_CONVERGED, _OUT_OF_REACH = int(Status.CONVERGED), int(Status.OUT_OF_REACH)
_NOT_CONVERGED = int(Status.NOT_CONVERGED)

_DEFAULT, _CURL = InverseOptions(), InverseOptions(tolerance=1e-3, tries=24)
"""Default options for targets and for circles."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True, repr=False)
class InverseSolution:
    """Tensions, cable lengths and equilibrium of each target; leading axes ``...`` are those of the batch."""

    shape: Shape
    """Equilibrium at these tensions, as `statics.solve` finds it from the straight trunk, or at the end of ``path``."""
    tension: np.ndarray
    """Tension of each cable, shape (..., n_cable) [N]."""
    pull: np.ndarray
    """Each cable pulled in since the straight trunk, negative for paid out, shape (..., n_cable) [m].

    Where a tension is 0: the largest pull that does not change the shape. Where several shapes have the same lengths,
    `statics.solve` finds this one from ``start=solution.shape``."""
    distance: np.ndarray
    """Residual, shape (...) [m]: distance of the tip, root mean square distance of the section ends, or of a curl the
    penetration of the deepest section or the gap of the nearest one."""
    status: np.ndarray
    """`Status`: CONVERGED, OUT_OF_REACH where the residual exceeds the tolerance, NOT_CONVERGED; shape (...) [-]."""
    turn: np.ndarray | None = None
    """Angle between the tip's direction and the target's, if it has one, shape (...) [rad]."""
    gap: np.ndarray | None = None
    """Gap between each section's surface and the circle of a curl, negative inside, shape (..., n_section) [m]."""
    path: LoadingPath | None = None
    """Where there is friction: which cable is loaded first and how each is held, for `statics.load_along`."""

    @property
    def points(self) -> np.ndarray:
        """Section ends, base to tip, shape (..., n_section, 3) [m]."""
        return self.shape.points

    @property
    def advice(self) -> str:
        """The gravest status in words."""
        return Status.worst(self.status).advice

    def __repr__(self) -> str:
        parts = [
            f"distance {describe_range(self.distance)} m", f"tension {describe_range(self.tension)} N",
            f"pull {describe_range(self.pull)} m",
        ]  # fmt: skip
        return describe_batch(self, self.status, parts if self.path is None else [*parts, repr(self.path)])


def solve(
    design: TrunkDesign,
    tip: ArrayLike,
    *,
    direction: ArrayLike | None = None,
    direction_weight: float = 0.05,
    theta_0: ArrayLike = math.pi / 2,
    roll: ArrayLike = 0.0,
    loads: Loads | None = None,
    friction: float | None = None,
    options: InverseOptions | None = None,
) -> InverseSolution:
    """Cable tensions for a tip position, or for position and direction in least squares.

    Minimises |tip - target|^2 + (direction_weight |axis - direction|)^2.

    Args:
        design: the trunk.
        tip: target position of the tip in the frame of `Shape`, shape (..., 3) [m].
        direction: target direction of the last section, of any length but 0, shape (..., 3) [-].
        direction_weight: length that weighs as much as one radian of direction [m].
        theta_0: angle of the base axis below the horizontal, shape (...) [rad]; pi / 2 hangs.
        roll: rotation of the trunk about its base axis, shape (...) [rad].
        loads: loads besides its weight.
        friction: coefficient between cables and holes [-]; None takes the design's, 0 by default.
        options: options of the search; ``samples`` is used without friction only.

    With friction the shape depends on the order of loading, and the solution's ``path`` is part of the answer: one
    cable may be held by a tension first, then one or two are pulled to their lengths, one after the other.
    `statics.load_along` with this path, base pose, loads, friction and ``options.statics`` gives the solution's shape.

    Returns:
        Tensions, pulls and shape; the status is OUT_OF_REACH where the residual exceeds the tolerance.

    Raises:
        ModelError: for wrong shapes, and numbers that are not finite or out of range.
        DesignError: for a friction out of range, and arguments of another type.
    """
    check_type("design", design, TrunkDesign)
    options = _read_options(options, _DEFAULT)
    mu = read_friction(design, friction, options)
    wanted, count = read_numbers("tip", tip, _PLACES, shape=(..., 3), unit="m"), design.n_section
    aimed: np.ndarray = np.zeros(3) if direction is None else _read_unit("direction", direction)
    weight = float(read_numbers("direction_weight", direction_weight, Range(least=1e-6, most=1e3), shape=()))
    batch = broadcast_batches({"tip": wanted.shape[:-1], "direction": aimed.shape[:-1]})
    cases, batch = read_load_cases((theta_0, roll), loads, batch)
    point, heading, last = np.zeros((*batch, count, 3)), np.zeros((*batch, 3)), np.zeros(count)
    point[..., -1, :], heading[:], last[-1] = wanted, aimed, 1.0
    point, heading = point.reshape(-1, count, 3), heading.reshape(-1, 3)
    turn, path = 0.0 if direction is None else weight, None
    if mu > 0:
        goals = [Goal(end, way, turn) for end, way in zip(point[:, -1], heading, strict=True)]
        shape, path = solve_with_friction(design, cases, goals, mu, options, batch=batch)
    else:
        targets = _build_targets(design, point=point, weight=last, heading=heading, turn=turn)
        shape = solve_targets(design, cases, targets, options, batch)
    away = shape.points[..., -1, :] - wanted
    x, y, z = away[..., 0], away[..., 1], away[..., 2]
    distance = np.sqrt(x * x + y * y + z * z)
    if direction is None:
        return _build_solution(shape, distance, distance <= options.tolerance, path=path)
    chord = np.linalg.norm(section_axes(shape.points)[..., -1, :] - aimed, axis=-1)
    is_reached = np.hypot(distance, turn * chord) <= options.tolerance
    return _build_solution(shape, distance, is_reached, turn=2 * np.arcsin(np.minimum(chord / 2, 1.0)), path=path)


def follow(
    design: TrunkDesign,
    points: ArrayLike,
    *,
    weight: ArrayLike | None = None,
    theta_0: ArrayLike = math.pi / 2,
    roll: ArrayLike = 0.0,
    loads: Loads | None = None,
    friction: float | None = None,
    options: InverseOptions | None = None,
) -> InverseSolution:
    """Cable tensions for a whole shape: section ends nearest to given ones in weighted least squares.

    Args:
        design: the trunk.
        points: target section ends, base to tip, shape (..., n_section, 3) [m].
        weight: weight of each, shape (n_section,) [-]; equal by default.
        theta_0: angle of the base axis below the horizontal, shape (...) [rad].
        roll: rotation of the trunk about its base axis, shape (...) [rad].
        loads: loads besides its weight.
        friction: coefficient between cables and holes [-], 0 alone; None takes the design's, 0 by default.
        options: options of the search.

    Returns:
        Tensions, pulls and shape; the distance is the weighted root mean square of the section ends' distances.

    Raises:
        ModelError: for wrong shapes, numbers that are not finite or out of range, and friction.
        DesignError: for a friction out of range, and arguments of another type.
    """
    check_type("design", design, TrunkDesign)
    _refuse_friction("follow", design, friction)
    count = design.n_section
    wanted = read_numbers("points", points, _PLACES, shape=(..., count, 3), unit="m")
    share = read_numbers("weight", np.ones(count) if weight is None else weight, Range(least=0.0), shape=(count,))
    if not share.any():
        raise ModelError("weight is 0 for every section; allowed: at least one above 0")
    cases, batch = read_load_cases((theta_0, roll), loads, wanted.shape[:-2])
    point = np.broadcast_to(wanted, (*batch, count, 3)).reshape(-1, count, 3).copy()
    share = share / share.sum()
    options = _read_options(options, _DEFAULT)
    shape = solve_targets(design, cases, _build_targets(design, point=point, weight=np.sqrt(share)), options, batch)
    distance = np.sqrt((share * ((shape.points - wanted) ** 2).sum(axis=-1)).sum(axis=-1))
    return _build_solution(shape, distance, distance <= options.tolerance)


def curl(
    design: TrunkDesign,
    center: ArrayLike,
    diameter: ArrayLike,
    *,
    normal: ArrayLike = (0.0, 0.0, 1.0),
    touching: int | None = None,
    theta_0: ArrayLike = math.pi / 2,
    roll: ArrayLike = 0.0,
    loads: Loads | None = None,
    friction: float | None = None,
    options: InverseOptions | None = None,
) -> InverseSolution:
    """Cable tensions that curl the trunk round a circle so that the sections' outer surfaces touch it.

    Minimises the squared gaps of the sections that should touch and the squared distances of all sections from the
    circle's plane; penetration of the circle weighs 30 times as much as a gap. There is no contact force between trunk
    and circle.

    Args:
        design: the trunk.
        center: centre of the circle in the frame of `Shape`, shape (..., 3) [m].
        diameter: shape (...) [m].
        normal: normal of the circle's plane, any length but 0, shape (..., 3) [-].
        touching: number of sections, counted from the tip, that should touch; by default those of the last
            250 degrees round each circle.
        theta_0: angle of the base axis below the horizontal, shape (...) [rad].
        roll: rotation of the trunk about its base axis, shape (...) [rad].
        loads: loads besides its weight.
        friction: as of `follow`.
        options: options of the search; the tolerance is the largest gap that counts as contact, 1 mm by default.

    Returns:
        Tensions, pulls and shape, with the gap of every section; OUT_OF_REACH where no section comes within the
        tolerance of the circle, or one penetrates it deeper.

    Raises:
        ModelError: for wrong shapes, numbers that are not finite or out of range, and friction.
        DesignError: for a friction out of range, and arguments of another type.
    """
    check_type("design", design, TrunkDesign)
    _refuse_friction("curl", design, friction)
    middle, axis = read_numbers("center", center, _PLACES, shape=(..., 3), unit="m"), _read_unit("normal", normal)
    width = read_numbers("diameter", diameter, Range(least=1e-6, most=_PLACES.most), unit="m")
    batch = broadcast_batches({"center": middle.shape[:-1], "normal": axis.shape[:-1], "diameter": width.shape})
    cases, batch = read_load_cases((theta_0, roll), loads, batch)
    circle = np.concatenate(
        [np.broadcast_to(part, (*batch, part.shape[-1])) for part in (middle, axis, width[..., None] / 2)], axis=-1
    ).reshape(-1, 7)
    options = _read_options(options, _CURL)
    touch = _touching(design, touching, 2 * circle[:, 6])
    targets = _build_targets(design, circle=np.ascontiguousarray(circle), touch=touch, deep=_DEEP)
    shape = solve_targets(design, cases, targets, replace(options, tolerance=1e-6), batch)
    points = shape.points.reshape(-1, design.n_section, 3)
    gap = np.empty(points.shape[:-1])
    gap_rows(points, section_axes(points), targets, gap)
    gap = gap.reshape(shape.points.shape[:-1])
    distance = np.abs(gap.min(axis=-1))
    return _build_solution(shape, distance, distance <= options.tolerance, gap=gap)


def _refuse_friction(function: str, design: TrunkDesign, friction: float | None) -> None:
    """Refuse friction, with which the shape depends on the order of loading, where no loading path is searched for."""
    mu = read_friction(design, friction, _DEFAULT)
    if mu > 0:
        raise ModelError(
            f"friction is {mu:g}; allowed in {function}: 0, as friction=0.0 for a design with friction; "
            "`solve` takes friction into account"
        )


def _touching(design: TrunkDesign, touching: int | None, width: np.ndarray) -> np.ndarray:
    """1 for the sections that should touch a circle of each width, 0 for the others, shape (b, n_section) [-]."""
    count = design.n_section
    if touching is None:
        each, row = np.unique(width, return_inverse=True)
        first = np.array([first_wrapped(snug_bend(design, one)) for one in each.tolist()], int)[row]
    else:
        check_count("touching", touching, least=1, most=count)
        first = np.full(width.shape, count - touching)
    return np.where(np.arange(count) >= first[:, None], 1.0, 0.0)


def _build_targets(design: TrunkDesign, **parts: Any) -> Targets:
    """Targets of the kernels; parts that are not given have no weight."""
    rows = len(parts["circle"] if "circle" in parts else parts["point"])
    return (_keep_no_targets(IdentityKey(design)) if rows == 1 else build_no_targets(design, rows))._replace(**parts)


@lru_cache(maxsize=64)
def _keep_no_targets(key: IdentityKey[TrunkDesign]) -> Targets:
    """`build_no_targets` for one target, cached; nothing is written into it."""
    return build_no_targets(key.value, 1)


def _build_solution(
    shape: Shape,
    distance: np.ndarray,
    is_reached: np.ndarray,
    *,
    turn: np.ndarray | None = None,
    gap: np.ndarray | None = None,
    path: LoadingPath | None = None,
) -> InverseSolution:
    """The solution, with the batch axes of the shape."""
    has_failed = shape.status == _NOT_CONVERGED
    if shape.status.ndim == 0:
        status = np.array(_NOT_CONVERGED if has_failed else _CONVERGED if is_reached else _OUT_OF_REACH)
    else:
        status = np.where(has_failed, _NOT_CONVERGED, np.where(is_reached, _CONVERGED, _OUT_OF_REACH))
    tension = shape.cable_change * 0 if shape.forces is None else shape.forces.cable_tension
    pull = shape.cable_change if path is None else np.where(path.by_tension, shape.cable_change, path.pull)
    return InverseSolution(
        shape=shape, tension=tension, pull=pull, distance=np.asarray(distance), status=status,
        turn=None if turn is None else np.asarray(turn), gap=gap, path=path,
    )  # fmt: skip


def _read_unit(name: str, value: ArrayLike) -> np.ndarray:
    array = read_numbers(name, value, shape=(..., 3))
    size = np.abs(array).max(axis=-1, keepdims=True) if array.size else np.ones(1)
    if not (size > 0).all():
        raise ModelError(f"{name} has length 0; allowed: a direction")
    array = array / size
    return array / np.linalg.norm(array, axis=-1, keepdims=True)


def _read_options(options: InverseOptions | None, usual: InverseOptions) -> InverseOptions:
    if options is None:
        return usual
    check_type("options", options, InverseOptions)
    return options
