"""Multistart search for cable tensions; every solution is the equilibrium found from the straight trunk."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any, final

import numpy as np
from numpy.typing import ArrayLike

from spiraltrunk.checks import broadcast_batches, check_count, check_number, check_type, read_numbers
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import ModelError
from spiraltrunk.field_docs import explain_fields
from spiraltrunk.model.identity_cache import IdentityKey
from spiraltrunk.model.inverse.kernels.multistart import Limits, solve_target_rows
from spiraltrunk.model.inverse.kernels.target_residual import Targets
from spiraltrunk.model.inverse.start_table import (
    CHUNK,
    LoadCase,
    StartTable,
    count_bends,
    get_start_table,
    pose_tensions,
)
from spiraltrunk.model.jit import share
from spiraltrunk.model.kinematics.frames import base_orientation
from spiraltrunk.model.kinematics.shape import MOST_TURNED, Shape
from spiraltrunk.model.statics.equilibrium import StaticsOptions
from spiraltrunk.model.statics.kernels.batch import Problem
from spiraltrunk.model.statics.kernels.laws.energy import Trunk
from spiraltrunk.model.statics.loads import Loads, read_angle, read_forces
from spiraltrunk.model.statics.solutions import allocate, build_shape

_CLOSE = 0.02
"""Distance over the trunk's length beyond which a start's tension does not affect its rank [-]."""

_STEP = math.radians(15.0)
"""Grid of the tilts for which start tables are computed [rad]; rolls twice this, loads 50 g and 0.5 N. Without a grid a
moving base would need a new table at every pose."""

_APART = 0.08
"""Least distance between the tips of every other start over the trunk's length [-]."""


_NONE = Loads()


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class InverseOptions:
    """Options of the search."""

    tolerance: float = 5e-5
    """Largest distance at which a target counts as reached [m]."""
    tries: int = 16
    """Largest number of starts."""
    samples: int = 400
    """Size of the start table, computed once per load case, from which the nearest equilibria are taken as starts."""
    rounds: int = 60
    """Largest number of equilibria solved from one start."""
    statics: StaticsOptions = field(default_factory=StaticsOptions)
    """Model of the trunk."""

    def __post_init__(self) -> None:
        check_type("statics", self.statics, StaticsOptions)
        check_number("tolerance", self.tolerance, least=1e-7, below=1.0)
        check_count("tries", self.tries, least=1, most=1000)
        check_count("samples", self.samples, least=1, most=10**5)
        check_count("rounds", self.rounds, least=1, most=10**4)


@final
@dataclass(frozen=True, kw_only=True)
class LoadCases:
    """Base poses and loads, one row a target."""

    cases: list[LoadCase]
    """Each row as plain numbers."""
    theta_0: np.ndarray
    """Angle of the base axis below the horizontal, shape (b,) [rad]."""
    roll: np.ndarray
    """Turn about the base axis, shape (b,) [rad]."""
    loads: Loads
    """Masses of shape (b,) [kg], forces of shape (b, 3) [N]."""


def read_load_cases(
    base: tuple[ArrayLike, ArrayLike], loads: Loads | None, batch: tuple[int, ...]
) -> tuple[LoadCases, tuple[int, ...]]:
    """Load cases of all targets, and the batch axes of targets, base poses and loads together.

    Args:
        base: theta_0 and roll, shape (...) each [rad].
        loads: loads, None for none.
        batch: batch axes of the targets.

    Raises:
        ModelError: where they are not angles and loads, are empty, or do not broadcast.
    """
    single = _read_single(*base) if loads is None and not batch else None
    if single is not None:
        return single, ()
    theta_0, roll = read_angle("theta_0", base[0]), read_angle("roll", base[1])
    loads = _NONE if loads is None else loads
    check_type("loads", loads, Loads)
    mass = read_numbers("loads.mass", loads.mass)
    force = None if loads.force is None else read_numbers("loads.force", loads.force, shape=(..., 3))
    batches = {
        "targets": batch, "theta_0": theta_0.shape, "roll": roll.shape, "loads.mass": mass.shape,
        "loads.force": () if force is None else force.shape[:-1],
    }  # fmt: skip
    batch = broadcast_batches(batches)
    if 0 in batch:
        raise ModelError("targets, theta_0, roll and loads are empty; allowed: at least one of each")
    theta_0, roll, mass = _spread(theta_0, batch), _spread(roll, batch), _spread(mass, batch)
    force = None if force is None else np.broadcast_to(force, (*batch, 3)).reshape(-1, 3)
    at = loads.section, loads.force_section
    forces = [None] * mass.size if force is None else map(tuple, force.tolist())
    cases = [
        LoadCase(down, turn, weight, at[0], pull, at[1])
        for down, turn, weight, pull in zip(theta_0.tolist(), roll.tolist(), mass.tolist(), forces, strict=True)
    ]
    spread = Loads(mass=mass, section=at[0], force=force, force_section=at[1])
    return LoadCases(cases=cases, theta_0=theta_0, roll=roll, loads=spread), batch


def _read_single(theta_0: ArrayLike, roll: ArrayLike) -> LoadCases | None:
    """The load case of one target without loads whose theta_0 and roll are floats; a fast path without arrays."""
    if not (type(theta_0) is type(roll) is float and abs(theta_0) <= MOST_TURNED and abs(roll) <= MOST_TURNED):
        return None
    case = LoadCase(theta_0, roll, 0.0, _NONE.section, None, _NONE.force_section)
    return LoadCases(cases=[case], theta_0=np.array((theta_0,)), roll=np.array((roll,)), loads=_NONE)


def _spread(array: np.ndarray, batch: tuple[int, ...]) -> np.ndarray:
    """One number a row."""
    return np.broadcast_to(array, batch).ravel() if batch else array.reshape(1)


def solve_targets(
    design: TrunkDesign, load_cases: LoadCases, targets: Targets, options: InverseOptions, batch: tuple[int, ...]
) -> Shape:
    """The equilibrium nearest to each target, solved from the straight trunk at the tensions found.

    Returns:
        Shapes with the batch's axes.
    """
    key, count = IdentityKey(design), len(load_cases.cases)
    posed, trunk = _keep_posed(key, options) if count == 1 else pose_tensions(design, count, options.statics)
    forces = _build_forces(design, load_cases)
    problem = Problem(*forces, *posed)
    solution = allocate(trunk, count)
    for case, members in _group_rows(load_cases.cases).items():
        table, limits = _keep_start_table(key, round_case(case), options)
        rows, turn = np.array(members), np.dot(forces[0][members[0]], table.base.T)
        _seek(rows, limits, (case.loads is None, trunk, problem, targets, table.starts, turn, solution))
    return build_shape(solution, batch)


@lru_cache(maxsize=64)
def _keep_posed(key: IdentityKey[TrunkDesign], options: InverseOptions) -> tuple[tuple[np.ndarray, ...], Trunk]:
    """`_pose_tensions` for one target, cached; nothing is written into it."""
    return pose_tensions(key.value, 1, options.statics)


@lru_cache(maxsize=128)
def _keep_start_table(
    key: IdentityKey[TrunkDesign], case: LoadCase, options: InverseOptions
) -> tuple[StartTable, Limits]:
    """Start table, and the limits of a search from it."""
    table, length = get_start_table(key.value, case, options.samples, options.statics), key.value.length
    return table, Limits(
        options.tries, options.rounds, options.tolerance, _APART * length, _CLOSE * length,
        count_bends(options.statics), table.slack,
    )  # fmt: skip


def _seek(rows: np.ndarray, limits: Limits, rest: tuple[Any, ...]) -> None:
    """Search several targets on all cores, in chunks so that Ctrl-C is handled."""
    share(lambda first, last: solve_target_rows(rows[first:last], limits, *rest), rows.size, CHUNK)


def _build_forces(design: TrunkDesign, load_cases: LoadCases) -> list[np.ndarray]:
    """Axes of the base, and direction, factor and moment of the forces, one row a target, as the kernels read them."""
    is_single, case = len(load_cases.cases) == 1, load_cases.cases[0]
    base = base_orientation(*((case.theta_0, case.roll) if is_single else (load_cases.theta_0, load_cases.roll)))
    forces = read_forces(design, case.loads if is_single else load_cases.loads)
    parts = base, forces.direction, forces.factor, forces.moment
    return [np.array(part[None] if is_single else part, order="C") for part in parts]


def _group_rows(cases: list[LoadCase]) -> dict[LoadCase, list[int]]:
    """Indices of the rows of each load case."""
    groups: dict[LoadCase, list[int]] = {}
    for b, case in enumerate(cases):
        groups.setdefault(case, []).append(b)
    return groups


def round_case(case: LoadCase) -> LoadCase:
    """The load case on the grid for which a start table is computed."""
    force = None if case.force is None else tuple(round(2 * part) / 2 for part in case.force)
    down = min(max(_STEP * round(case.theta_0 / _STEP), -MOST_TURNED), MOST_TURNED)
    return LoadCase(
        down, 2 * _STEP * round(case.roll / (2 * _STEP)), round(20 * case.mass) / 20,
        case.section, force, case.force_section,
    )  # fmt: skip
