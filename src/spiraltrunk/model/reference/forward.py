"""The forward model of "Grasping by Spiraling": rest under gravity, bending by Algorithm 1, twisting by Algorithm 2.

All laws return a `Shape`; pulls in m, angles in rad, scalars or arrays that broadcast against each other. theta_0 is
the angle of the base axis below the horizontal: 90 deg hangs, -90 deg stands upright. The status is ALL_SHUT where
every joint that can move is at its limit and cable is left over. A `ModelError` refuses numbers that are not finite or
out of range, and cables that do not fit.

With ``as_authors``, the default, the numbers are those of the authors' published code: its rounded constants (k_p of
the gravity equations 0.9196, R_hole 28.87 mm, straight gap 13.74 mm, all kept as ratios to what the design gives) and
its treatment of cable that a full joint cannot take, of which some is lost (`bend_ventral`, `twist`). Without it the
constants are the design's own and all cable is taken by joints that have room. Where the authors' code fails (no joint
closed by cable 1) or exceeds the limit (by 0.0034 deg at full ventral curl) both variants follow the paper.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import ArrayLike

from spiraltrunk.checks import Range, broadcast_batches, read_numbers
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import ModelError
from spiraltrunk.model.jit import share
from spiraltrunk.model.kinematics.cables import pull_range
from spiraltrunk.model.kinematics.shape import MOST_TURNED, Shape, build
from spiraltrunk.model.reference.constants import Prepared, check_twist, check_ventral, prepare
from spiraltrunk.model.reference.dispatch import DORSAL, REST, TWIST, VENTRAL, solve
from spiraltrunk.model.reference.planar_batch import build_workspace, solve_points

_CHUNK = 2048
"""Shapes per chunk of a thread [-]."""

_LEAN_CHUNK = 16384
"""Shapes per chunk of `bend_dorsal_points`, which takes a tenth of the time; a multiple of its lanes [-]."""


def rest(design: TrunkDesign, theta_0: ArrayLike, *, as_authors: bool = True) -> Shape:
    """Shape that the trunk takes under its own weight, no cable pulled; cable 1 must be dorsal.

    Equation of the paper's section "Resting under gravity", corrected. Each section's mass acts at K_c of its length,
    the gripper's as part of the last section. A joint that would pass its limit is held there.
    """
    return _solve(REST, prepare(design, as_authors), (("theta_0", theta_0, math.inf),))


def bend_dorsal(design: TrunkDesign, pull: ArrayLike, theta_0: ArrayLike, *, as_authors: bool = True) -> Shape:
    """Shape after cable 1 is pulled in from rest, tip first (paper, Algorithm 1).

    Args:
        design: the trunk; cable 1 dorsal.
        pull: shortening of cable 1 from rest, 0 to 1.01 times the stroke, shape (...) [m].
        theta_0: angle of the base axis below the horizontal, shape (...) [rad].
        as_authors: whether to use the authors' rounded numbers.
    """
    prepared = prepare(design, as_authors)
    return _solve(DORSAL, prepared, (("pull", pull, prepared.stroke), ("theta_0", theta_0, math.inf)))


@final
@dataclass(frozen=True, kw_only=True)
class PlaneShape:
    """Section ends and bends of many shapes."""

    points: np.ndarray
    """Section ends, base to tip, shape (..., n_section, 3) [m]; not a number where the rest did not converge."""
    bend: np.ndarray
    """Bend of each joint about z, dorsal positive, shape (..., n_joint) [rad]; kept joint by joint."""


def bend_dorsal_points(
    design: TrunkDesign,
    pull: ArrayLike,
    theta_0: ArrayLike,
    *,
    as_authors: bool = True,
    out: PlaneShape | None = None,
) -> PlaneShape:
    """Section ends and bends of `bend_dorsal`, to the bit, in about a tenth of its time where theta_0 repeats.

    In memory the batch is the innermost axis: each coordinate of each section end is contiguous over the shapes, as is
    each joint's bend; `numpy.ascontiguousarray` gives the usual order. ``out`` is an earlier result of the same shape,
    which is overwritten and returned, except z, which must still be 0: allocation takes nearly half of the time.
    """
    prepared = prepare(design, as_authors)
    arrays, batch = _read((("pull", pull, prepared.stroke), ("theta_0", theta_0, math.inf)))
    n, n_joint = math.prod(batch), prepared.n_joint
    pulls, tilts = (np.broadcast_to(array, batch).ravel() if array.ndim else array.reshape(1) for array in arrays)
    pulls = pulls if pulls.size == n else np.full(n, pulls[0])
    if out is None:
        ends, bend = np.zeros((3, n_joint + 1, n)), np.empty((n_joint, n))
        out = PlaneShape(points=ends.T.reshape(*batch, n_joint + 1, 3), bend=bend.T.reshape(*batch, n_joint))
    else:
        ends, bend = _read_out(out, batch, n_joint)

    def solve_span(first: int, last: int) -> None:
        solve_points((pulls, tilts, build_workspace(n_joint)), prepared.constants, ends, bend, (first, last))

    share(solve_span, n, _LEAN_CHUNK)
    return out


def _read_out(out: PlaneShape, batch: tuple[int, ...], n_joint: int) -> tuple[np.ndarray, np.ndarray]:
    """Section ends (3, n_section, n) and bends (n_joint, n) in the memory of a result."""
    n, shape = math.prod(batch), (*batch, n_joint + 1, 3)
    if out.points.shape != shape or out.bend.shape != (*batch, n_joint):
        raise ModelError(f"out.points has shape {out.points.shape}; allowed here: {shape}")
    ends, bend = out.points.reshape(n, n_joint + 1, 3).T, out.bend.reshape(n, n_joint).T
    are_ours = all(
        array.dtype == float and array.flags.carray and np.may_share_memory(array, given)
        for array, given in ((ends, out.points), (bend, out.bend))
    )
    if n and not are_ours:
        raise ModelError("out has another memory layout; allowed: the result of an earlier call")
    return ends, bend


def bend_ventral(design: TrunkDesign, lengthening: ArrayLike, theta_0: ArrayLike, *, as_authors: bool = True) -> Shape:
    """Shape after the ventral cables are pulled in equally while cable 1 is let out, tip first (paper, Algorithm 1).

    The authors' code measures what a full joint passes on from the straight gap and not from the gap at rest, so that
    cable is lost or gained where gravity bends the trunk; without ``as_authors`` all of it is accounted for.

    Args:
        design: the trunk; cable 1 dorsal, the others mirroring each other.
        lengthening: lengthening of cable 1 from rest, 0 to 1.01 times that of full curl, shape (...) [m].
        theta_0: angle of the base axis below the horizontal, shape (...) [rad].
        as_authors: whether to use the authors' rounded numbers and account.
    """
    prepared = prepare(design, as_authors)
    check_ventral(design, prepared)
    given = ("lengthening", lengthening, prepared.ventral_stroke), ("theta_0", theta_0, math.inf)
    return _solve(VENTRAL, prepared, given)


def twist(
    design: TrunkDesign, pull_1: ArrayLike, pull_2: ArrayLike, theta_0: ArrayLike, *, as_authors: bool = True
) -> Shape:
    """Shape after cable 1 is pulled in from rest and then cable 2 (paper, Algorithm 2).

    Joints from the first that cable 1 has shut move rigidly (all may turn where it has shut none); the others turn
    about the line through their centre and the hole of cable 1. A joint that is full passes the excess to those nearer
    to the base; in the authors' code some of it is lost then, without ``as_authors`` none.

    Args:
        design: the trunk; cables at 0, 120 and 240 deg.
        pull_1: shortening of cable 1 from rest, 0 to 1.01 times the stroke, shape (...) [m].
        pull_2: shortening of cable 2 after that, 0 to 1.01 times the stroke, shape (...) [m].
        theta_0: angle of the base axis below the horizontal, shape (...) [rad].
        as_authors: whether to use the authors' rounded numbers and account.
    """
    prepared = prepare(design, as_authors)
    check_twist(design, prepared)
    given = ("pull_1", pull_1, prepared.stroke), ("pull_2", pull_2, prepared.stroke), ("theta_0", theta_0, math.inf)
    return _solve(TWIST, prepared, given)


def first_shut(shape: Shape) -> np.ndarray:
    """First joint, from the base, whose gap of cable 1 is shut: 1 to n_joint, n_joint + 1 where none, shape (...) [-].

    After `bend_dorsal` by the first pull this is the joint from which `twist` moves the trunk rigidly.
    """
    shut = shape.is_shut & (shape.gap[..., 0] <= 1e-6 * shape.gap.max(axis=-1))
    return np.where(shut.any(axis=-1), shut.argmax(axis=-1), shut.shape[-1]) + 1


_ANGLES = Range(least=-MOST_TURNED, most=MOST_TURNED)

_Given = tuple[str, ArrayLike, float]
"""Name of an input, its value, and the largest pull [m]: that which closes every gap, or infinity for an angle."""


def _read_plain(given: tuple[_Given, ...]) -> list[float] | None:
    """The inputs as floats where each is a number within its range, else None."""
    numbers: list[float] = []
    for _, value, full in given:
        if not (isinstance(value, (float, int)) and abs(value) < min(full, MOST_TURNED)):
            return None
        if value < 0.0 and full != math.inf:
            return None
        numbers.append(float(value))
    return numbers


def _read(given: tuple[_Given, ...]) -> tuple[list[np.ndarray], tuple[int, ...]]:
    """The inputs as checked arrays, and the shape to which they broadcast."""
    arrays = {}
    for name, value, full in given:
        allowed, unit = (_ANGLES, "rad") if full == math.inf else (pull_range(full), "m")
        arrays[name] = read_numbers(name, value, allowed, unit=unit)
    return list(arrays.values()), broadcast_batches({name: array.shape for name, array in arrays.items()})


def _solve(law: int, prepared: Prepared, given: tuple[_Given, ...]) -> Shape:
    """Shapes for the inputs, the last of them theta_0; large batches on all cores."""
    numbers = _read_plain(given)
    if numbers is not None:
        return _solve_one(law, prepared, numbers)
    arrays, batch = _read(given)
    if not batch:
        return _solve_one(law, prepared, [float(array) for array in arrays])
    n, n_joint = math.prod(batch), prepared.n_joint
    inputs = np.zeros((*batch, 3))
    for column, array in zip((*range(len(arrays) - 1), 2), arrays, strict=True):
        inputs[..., column] = array
    rows, count = inputs.reshape(n, 3), prepared.layout[-1][2]
    results = np.empty(n * count + -(-n * (n_joint + 1) // 8))

    def solve_span(first: int, last: int) -> None:
        workspace = prepared.build_workspace()[1]
        workspace[:2] = first, last
        solve(law, rows, workspace, prepared.constants, results)

    share(solve_span, n, _CHUNK)
    flags = results[n * count :].view(np.uint8)
    parts: list[np.ndarray] = [
        results[n * start : n * end].reshape(batch + shape) for shape, start, end in prepared.layout
    ]
    parts += [flags[: n * n_joint].view(np.bool_).reshape((*batch, n_joint)), flags[n * n_joint :][:n].reshape(batch)]
    return build(Shape, dict(zip(_FIELDS, parts, strict=True)) | {"forces": None, "history": None})


_FIELDS = "points", "joint_rotation", "joint_angle", "gap", "cable_change", "is_shut", "status"


def _solve_one(law: int, prepared: Prepared, numbers: list[float]) -> Shape:
    """The shape for single inputs; its arrays are fields of one record, which is faster to allocate than many."""
    results = np.empty(prepared.record.itemsize // 8)
    free = prepared.workspaces.pop() if prepared.workspaces else prepared.build_workspace()
    inputs, workspace = free
    inputs[0, 0], inputs[0, 2] = numbers[0], numbers[-1]
    if len(numbers) == 3:
        inputs[0, 1] = numbers[1]
    solve(law, inputs, workspace, prepared.constants, results)
    prepared.workspaces.append(free)
    record = np.ndarray((), prepared.record, results)
    return build(
        Shape,
        {
            "points": record["points"], "joint_rotation": record["joint_rotation"],
            "joint_angle": record["joint_angle"], "gap": record["gap"], "cable_change": record["cable_change"],
            "is_shut": record["is_shut"], "status": record["status"], "forces": None, "history": None,
        },
    )  # fmt: skip
