"""The trunk reduced to planar curls: all its shapes that one cable makes by its tension alone, in any direction.

A curl is told by a vector b across the base, shape (2,) [m]: its direction is that in which the trunk bends, its length
s what a cable on that side takes up. Joint i is bent by q_i(s), the equilibrium of its stiffness with one tension T:

    K_i q_i = T R_i cos((delta - q_i) / 2),   0 <= q_i <= delta.

A cable whose direction d_c makes the angle psi with the bend crosses each gap in the length

    gap_i = 2 R_i (sin(delta / 2) cos(q_i / 2) - cos(delta / 2) sin(q_i / 2) cos psi),

which is exact in the plane of the bend (psi of 0 and pi), and elsewhere but for the different lean of a gap's two
faces. So it takes up ``A(s) + B(s) / s d_c . b``.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import final

import numpy as np

from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.field_docs import explain_fields

POINTS = 512
"""Points of a table (ours)."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class TrunkCurl:
    """Tables over s, at `POINTS` equal steps from 0 to the stroke."""

    step: float
    """Step of s [m]."""
    mass: float
    """Inertia of the curl, the mean over s of the sum of m |dx/ds|^2 over the sections [kg]; a mass that changed with
    the shape would need forces of its own to keep the energy."""
    force: tuple[float, ...]
    """Tension T that a lone cable needs without weight: derivative of the elastic energy [N]."""
    damping: tuple[float, ...]
    """Sum of K_i (dq_i/ds)^2 times the damping time of the joints [N s/m]."""
    common: tuple[float, ...]
    """A(s), taken up by every cable [m]."""
    lever: tuple[float, ...]
    """B(s) / s, taken up per component of b along the cable [-]."""
    axial: tuple[float, ...]
    """Sum of m x over the sections, x along the base axis [kg m]."""
    lateral: tuple[float, ...]
    """Sum of m y over the sections, divided by s [kg]."""


def tabulate_bends(design: TrunkDesign) -> tuple[np.ndarray, np.ndarray]:
    """Size s of a curl, shape (`POINTS`,) [m], and the bends of its joints, shape (`POINTS`, n_joint) [rad]."""
    bend, _ = _bends(design)
    s = np.linspace(0.0, design.cable_stroke, POINTS)
    common, along = _take_up(design, bend)
    return s, _resample(s, common + along, bend)


def compute_curl(design: TrunkDesign) -> TrunkCurl:
    """Tables of a design; the weight of a gripper is added to the last section's."""
    bend, tension = _bends(design)
    stiffness = design.joint_stiffness
    common, along = _take_up(design, bend)
    s = np.linspace(0.0, design.cable_stroke, POINTS)
    taken = common + along
    q, (common, along) = _resample(s, taken, bend), _resample(s, taken, np.stack([common, along], axis=-1)).T
    centre, mass = _centres(design, q), _masses(design)
    dq, dx = np.gradient(q, s, axis=0), np.gradient(centre, s, axis=0)
    tables = {
        "force": np.interp(s, taken, tension),
        "damping": design.joint.damping_time * (stiffness * dq**2).sum(axis=1),
        "common": common,
        "lever": _per_s(along, s),
        "axial": centre[:, :, 0] @ mass,
        "lateral": _per_s(centre[:, :, 1] @ mass, s),
    }
    inertia = float(np.einsum("n,snk->s", mass, dx**2).mean())
    return TrunkCurl(step=float(s[1]), mass=inertia, **{name: tuple(table.tolist()) for name, table in tables.items()})


def _take_up(design: TrunkDesign, bend: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Cable taken up by every cable, and by one in the plane of the bend in addition, shape (p,) [m]."""
    arm, half = design.hole_to_joint, design.delta_theta / 2
    common = (2 * arm * math.sin(half) * (1 - np.cos(bend / 2))).sum(axis=1)
    return common, (2 * arm * math.cos(half) * np.sin(bend / 2)).sum(axis=1)


def _resample(s: np.ndarray, taken: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Values at the equal steps of s, from those at the steps of the tension."""
    return np.stack([np.interp(s, taken, column) for column in values.T], axis=-1)


def _bends(design: TrunkDesign) -> tuple[np.ndarray, np.ndarray]:
    """Bends of the joints, shape (p, n_joint) [rad], and their tensions up to all gaps shut, shape (p,) [N]."""
    delta = design.delta_theta
    bend = np.linspace(0.0, delta, 400)
    law = bend / np.cos((delta - bend) / 2)
    per_tension = design.hole_to_joint / design.joint_stiffness
    tension = np.concatenate([[0.0], np.geomspace(1e-3, 1.0, 2000)]) * law[-1] / per_tension.min()
    return np.interp(tension[:, None] * per_tension, law, bend), tension


def _masses(design: TrunkDesign) -> np.ndarray:
    """Masses of the sections, with the gripper in the last one, shape (n_section,) [kg]."""
    mass = design.section_mass.copy()
    if design.gripper is not None:
        mass[-1] += design.gripper.mass
    return mass


def _centres(design: TrunkDesign, bend: np.ndarray) -> np.ndarray:
    """Centres of mass of the sections of planar curls, shape (POINTS, n_section, 2) [m]."""
    turn = np.concatenate([np.zeros((len(bend), 1)), np.cumsum(bend, axis=1)], axis=1)
    axis = np.stack([np.cos(turn), np.sin(turn)], axis=-1)
    ends = np.cumsum(design.section_length[:, None] * axis, axis=1)
    starts = np.concatenate([np.zeros_like(ends[:, :1]), ends[:, :-1]], axis=1)
    return starts + design.section_center[:, None] * axis


def _per_s(values: np.ndarray, s: np.ndarray) -> np.ndarray:
    """Values over s; at 0, where both vanish, their limit."""
    ratio = values[1:] / s[1:]
    return np.concatenate([[2 * ratio[0] - ratio[1]], ratio])
