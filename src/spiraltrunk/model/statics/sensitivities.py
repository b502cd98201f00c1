"""How a shape in equilibrium changes with what is done to it, and with what the trunk is made of, written out.

At an equilibrium the moments G(q, tensions, parameter) are zero along every free bend, and the held cables' lengths are
what the winders leave. By the implicit function theorem the bends follow from

    H dq + S^T dT + dG/dp dp = 0,   S dq + dl/dp dp = dl,

with H the Hessian of the energy, S the slopes of the cables' lengths, T the tensions. Joints pressed against their
limit move along their rim, so H, S and G are taken along it, and H has the reaction's share in the rim's curvature. The
answers hold where no joint is about to meet or leave its limit. There is no friction.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np

from spiraltrunk.design.rules import GRAVITY
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import ModelError
from spiraltrunk.model.kinematics.cables import hole_positions
from spiraltrunk.model.kinematics.frames import base_orientation
from spiraltrunk.model.kinematics.shape import Shape
from spiraltrunk.model.statics.equilibrium import StaticsOptions, build_trunk
from spiraltrunk.model.statics.kernels.energy import Case, Control, Friction, Trunk, Work, linearise, room_for_work
from spiraltrunk.model.statics.kernels.joint_limits import reduce
from spiraltrunk.model.statics.kernels.projected_newton import System, room_for_steps
from spiraltrunk.model.statics.loads import Loads, read_angle, read_fields

__all__ = ["ByCables", "by_cables", "by_parameters"]


@final
@dataclass(frozen=True, kw_only=True)
class ByCables:
    """Slopes of a shape by what its winders do."""

    points_by_tension: np.ndarray
    """Motion of the section ends per tension, all cables held by tension, shape (n_section, 3, n_cable) [m/N]."""
    points_by_pull: np.ndarray
    """Motion per cable pulled in, the others held by length too; 0 for relaxed cables, (n_section, 3, n_cable) [-]."""
    pull_by_tension: np.ndarray
    """Cable pulled in per tension, symmetric, shape (n_cable, n_cable) [m/N]."""
    tension_by_pull: np.ndarray
    """The inverse for the cables that are taut, 0 for the others, shape (n_cable, n_cable) [N/m]."""

    @property
    def tip_by_tension(self) -> np.ndarray:
        """Motion of the tip per tension, shape (3, n_cable) [m/N]."""
        return self.points_by_tension[-1]

    @property
    def tip_by_pull(self) -> np.ndarray:
        """Motion of the tip per cable pulled in, shape (3, n_cable) [-]."""
        return self.points_by_pull[-1]


def by_cables(
    design: TrunkDesign,
    shape: Shape,
    *,
    theta_0: float = np.pi / 2,
    roll: float = 0.0,
    loads: Loads | None = None,
    options: StaticsOptions | None = None,
) -> ByCables:
    """Slopes by tensions and by cable lengths.

    Args:
        design: the trunk.
        shape: one equilibrium from `statics.solve` without friction.
        theta_0: as solved [rad].
        roll: as solved [rad].
        loads: as solved.
        options: as solved.

    Raises:
        ModelError: where the shape is no equilibrium of this trunk as it stands, or is a batch.
    """
    slopes = _Slopes(design, shape, (theta_0, roll, loads), options or StaticsOptions())
    bend, taut = slopes.bend_by_tension, slopes.tension > 0
    give = -slopes.slope @ bend
    stiff = np.zeros_like(give)
    held = np.ix_(taut, taut)
    stiff[held] = np.linalg.inv(give[held] + np.diag(np.full(int(taut.sum()), slopes.compliance)))
    by_tension = slopes.motion @ bend
    return ByCables(
        points_by_tension=by_tension, points_by_pull=by_tension @ stiff, pull_by_tension=give, tension_by_pull=stiff
    )


def by_parameters(
    design: TrunkDesign,
    shape: Shape,
    *,
    is_held_by_length: bool = False,
    theta_0: float = np.pi / 2,
    roll: float = 0.0,
    loads: Loads | None = None,
    options: StaticsOptions | None = None,
) -> dict[str, np.ndarray]:
    """Motion of the section ends per change of every parameter that calibration fits.

    Args:
        design: the trunk.
        shape: one equilibrium from `statics.solve` without friction.
        is_held_by_length: whether the winders keep the taut cables' pulls, measured from the straight trunk; else they
            keep the tensions.
        theta_0: as solved [rad].
        roll: as solved [rad].
        loads: as solved.
        options: as solved.

    Returns:
        ``joint_stiffness`` (n_section, 3, n_joint) [m / (N m/rad)], ``section_mass`` (n_section, 3, n_section) [m/kg],
        and, each of shape (n_section, 3), ``center_fraction`` [m], ``hole_fraction`` [m], ``load_mass`` [m/kg],
        ``theta_0`` [m/rad] and ``roll`` [m/rad].

    Raises:
        ModelError: where the shape is no equilibrium of this trunk as it stands, or is a batch.
    """
    slopes = _Slopes(design, shape, (theta_0, roll, loads), options or StaticsOptions())
    load_section = -1 if loads is None else loads.section
    moments = {
        "joint_stiffness": slopes.moment_by_stiffness(),
        "section_mass": slopes.weigh(slopes.places(design.section_center / design.section_length)),
        "center_fraction": slopes.moment_by_center(design),
        "hole_fraction": slopes.moment_by_holes(design),
        "load_mass": slopes.weigh(slopes.motion[load_section]),
        "theta_0": slopes.moment_by_turn(np.array([0.0, 0.0, -1.0])),
        "roll": slopes.moment_by_turn(slopes.base[:, 0]),
    }
    lengthened = {"hole_fraction": slopes.pull_by_holes(design)}
    still = np.zeros(len(slopes.tension))
    answer = {
        name: slopes.follow(moment, lengthened.get(name, still), is_held_by_length) for name, moment in moments.items()
    }
    answer["theta_0"] += np.cross([0.0, 0.0, -1.0], shape.points)
    answer["roll"] += np.cross(slopes.base[:, 0], shape.points)
    return answer


@final
class _Slopes:
    """The equations of one equilibrium, linear, in the bends that are free."""

    def __init__(
        self,
        design: TrunkDesign,
        shape: Shape,
        stand: tuple[float, float, Loads | None],
        options: StaticsOptions,
    ) -> None:
        bend, self.tension = _read_shape(design, shape)
        self.trunk, self.options, self.bend = build_trunk(design, options), options, bend
        self.compliance = 1 / options.cable_stiffness
        self.case = _build_case(design, self.trunk, stand)
        self.base = self.case.base
        nd = 3 if options.has_torsion else 2
        self.work: Work = room_for_work(design.n_joint, design.n_cable, nd)
        self.system: System = room_for_steps(design.n_joint, design.n_cable, nd, self.trunk.stiffness)
        linearise(bend, self.case, self.tension, self.work)
        reduce(bend, self.trunk, self.work, self.system)
        self._check()
        lower = np.tril(self.work.hessian)
        self.hessian = lower + np.tril(lower, -1).T
        self.turning = self._turning()
        self.motion = self.places(np.ones(design.n_section))
        self.slope = self.reduced(self.work.slope.transpose(1, 0, 2).reshape(design.n_cable, -1))
        self.bend_by_tension = -self.solve(self.slope.T)

    def _check(self) -> None:
        left = float(np.abs(self.system.gradient).max())
        if left > 1e-5:
            raise ModelError(
                f"shape has moments of {left:.3g} N m left; allowed: an equilibrium of this trunk without "
                "friction, with the theta_0, roll, loads and options it was solved with"
            )

    def _turning(self) -> np.ndarray:
        """Turning of all that lies beyond a joint per rate of its bends, shape (n_joint, nd, 3) [-]."""
        spun = np.einsum("jaik,jlk->jail", self.work.first, self.work.rotation)
        vector = np.stack([spun[..., 2, 1], spun[..., 0, 2], spun[..., 1, 0]], axis=-1)
        return np.einsum("jxy,jay->jax", self.work.frames[:-1], vector)

    def places(self, part: np.ndarray) -> np.ndarray:
        """Motion of the points at parts of each section's length per rate of the free bends, (n_section, 3, size)."""
        axes = self.work.frames[:, :, 0] * self.trunk.length[:, None]
        ends = np.cumsum(axes, axis=0)
        lever = (ends - axes + part[:, None] * axes)[:, None] - ends[None, :-1]
        motion = np.cross(self.turning[None], lever[:, :, None])
        count = len(axes)
        motion[np.arange(count)[:, None] <= np.arange(count - 1)] = 0.0
        return self.reduced(motion.transpose(0, 3, 1, 2).reshape(count, 3, -1))

    def reduced(self, rows: np.ndarray) -> np.ndarray:
        """Slopes by all bends, last axis, along the free ones: of a pressed joint the rim's tangent alone."""
        nd, system = self.turning.shape[1], self.system
        out = rows.reshape((*rows.shape[:-1], -1, nd)).copy()
        for i in np.flatnonzero(system.pressed):
            cosine, sine = system.normal[i]
            out[..., i, 1] = cosine * out[..., i, 1] - sine * out[..., i, 0]
            out[..., i, 0] = 0.0
        return out.reshape(rows.shape)

    def solve(self, moment: np.ndarray) -> np.ndarray:
        """Bends under moments, shape (size, ...)."""
        return np.linalg.solve(self.hessian, moment)

    def follow(self, moment: np.ndarray, pull: np.ndarray, is_held_by_length: bool) -> np.ndarray:
        """Motion of the section ends, shape (n_section, 3, ...), per change that adds ``moment`` (size, ...) to G.

        ``pull`` is by how much each cable counts as pulled in more at the same shape, shape (n_cable,).
        """
        bend = -self.solve(moment)
        taut = self.tension > 0
        if is_held_by_length and taut.any():
            slope, way = self.slope[taut], self.bend_by_tension[:, taut]
            give = -slope @ way + self.compliance * np.eye(int(taut.sum()))
            late = (slope @ bend).T - pull[taut]
            bend = bend + way @ np.linalg.solve(give, late.T)
        return self.motion @ bend

    def weigh(self, motion: np.ndarray) -> np.ndarray:
        """Moments of 1 kg at points that move by ``motion`` (..., 3, size): shape (size, ...)."""
        return np.moveaxis(GRAVITY * motion[..., 1, :], -1, 0)

    def moment_by_stiffness(self) -> np.ndarray:
        """Each joint's bends are what its own stiffness multiplies, shape (size, n_joint) [rad]."""
        nd, count = self.turning.shape[1], len(self.bend)
        share = self.trunk.stiffness[:, :nd] / self.trunk.stiffness[:, :1]
        rows = np.zeros((count, count, nd))
        rows[np.arange(count), np.arange(count)] = self.bend[:, :nd] * share
        return self.reduced(rows.reshape(count, -1)).T

    def moment_by_center(self, design: TrunkDesign) -> np.ndarray:
        """All centres of mass move along their sections by a part of their lengths, shape (size,) [N m]."""
        along = self.motion - self.places(np.zeros(design.n_section))
        return self.weigh(np.tensordot(design.section_mass, along, axes=1))

    def moment_by_turn(self, axis: np.ndarray) -> np.ndarray:
        """The whole trunk turns about ``axis``: as if the forces turned the other way, shape (size,) [N m/rad]."""
        direction, factor, moment = self.case.field
        total = np.zeros(self.motion.shape[-1])
        nothing = self.places(np.zeros(len(self.trunk.length)))
        for force, share, arm in zip(direction, factor, moment, strict=True):
            along = (self.motion - nothing) / self.trunk.length[:, None, None]
            place = share[:, None, None] * nothing + arm[:, None, None] * along
            total -= np.einsum("nxs,x->s", place, np.cross(force, axis))
        return total

    def _by_holes(self, design: TrunkDesign) -> tuple[np.ndarray, np.ndarray]:
        """Gaps and their slopes by the hole fraction, shapes (n_joint, n_cable) and (n_joint, n_cable, nd)."""
        beyond, before = hole_positions(design)
        far, near = beyond / design.cable.hole_fraction, before / design.cable.hole_fraction
        vector = np.einsum("jxy,jcy->jcx", self.work.rotation, self.trunk.beyond) - self.trunk.before
        change = np.einsum("jxy,jcy->jcx", self.work.rotation, far) - near
        gap = np.sqrt((vector**2).sum(axis=-1) + self.trunk.shut**2)
        by_hole = (vector * change).sum(axis=-1) / gap
        turned = np.einsum("jaxy,jcy->jcax", self.work.first, self.trunk.beyond)
        turned_more = np.einsum("jaxy,jcy->jcax", self.work.first, far)
        slope = (np.einsum("jcx,jcax->jca", change, turned) + np.einsum("jcx,jcax->jca", vector, turned_more)) / gap[
            ..., None
        ]
        return by_hole, slope - self.work.slope * (by_hole / gap)[..., None]

    def moment_by_holes(self, design: TrunkDesign) -> np.ndarray:
        """Levers of all cables grow with the hole fraction, shape (size,) [N m]."""
        _, slope = self._by_holes(design)
        return self.reduced(np.einsum("c,jca->ja", self.tension, slope).reshape(-1))

    def pull_by_holes(self, design: TrunkDesign) -> np.ndarray:
        """Cable that counts as pulled in more with the hole fraction at the same shape, shape (n_cable,) [m]."""
        beyond, before = hole_positions(design)
        apart = self.trunk.beyond - self.trunk.before
        straight = (apart * (beyond - before)).sum(axis=-1) / np.linalg.norm(apart, axis=-1)
        by_hole, _ = self._by_holes(design)
        return (straight / design.cable.hole_fraction - by_hole).sum(axis=0)


def _read_shape(design: TrunkDesign, shape: Shape) -> tuple[np.ndarray, np.ndarray]:
    if shape.history is None or shape.forces is None:
        raise ModelError("shape has no forces; allowed: a shape from statics.solve")
    if shape.points.shape != (design.n_section, 3):
        raise ModelError(
            f"shape has points of shape {shape.points.shape}; allowed: one shape of {design.n_section} sections"
        )
    return shape.history.bend.copy(), shape.forces.cable_tension.copy()


def _build_case(design: TrunkDesign, trunk: Trunk, stand: tuple[float, float, Loads | None]) -> Case:
    theta_0, roll, loads = stand
    fields = read_fields(design, loads)
    base = base_orientation(read_angle("theta_0", theta_0), read_angle("roll", roll))
    if base.shape != (3, 3) or fields.factor.ndim != 2:
        raise ModelError("theta_0, roll or loads are a batch; allowed: one number each")
    nothing, idle = np.zeros(design.n_cable), np.zeros((design.n_joint, design.n_cable))
    field = tuple(np.array(part, order="C") for part in (fields.direction, fields.factor, fields.moment))
    return Case(
        base, trunk, (field[0], field[1], field[2]), Control(np.full(design.n_cable, True), nothing, nothing, nothing),
        Friction(idle, idle, idle, 0.0),
    )  # fmt: skip
