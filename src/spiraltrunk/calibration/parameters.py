"""Parameters that a calibration fits, and their Gaussian prior.

The parameter vector holds, in this order, the logarithm of each joint's stiffness and of the mass, both over the
design's, the shift of the centre of mass over the section's length, the friction coefficient, the slack of each cable
[m], the shift of the hole fraction, and the compliance of winder and cable [m/N].
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields, replace
from typing import final

import numpy as np

from spiraltrunk.checks import check_count, check_number
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import ModelError
from spiraltrunk.field_docs import explain_fields

_MOST_COMPLIANCE = 1e-2
"""Largest compliance of a winder [m/N]: equilibria bear no more."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class Winders:
    """What lies between a winder's command and the cable's length, and is no part of a design."""

    slack: np.ndarray
    """Cable that each winder takes in before it pulls, shape (n_cable,) [m]."""
    compliance: float = 0.0
    """Lengthening of each winder with its cable per tension [m/N]."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class Prior:
    """What is known before the recordings: standard deviations about the design, and three means."""

    stiffness_level: float = 0.4
    """Of the logarithm of all joints' stiffness together [-] (ours: moduli of printed TPU 95A differ by half)."""
    stiffness_exponent: float = 1.0
    """Of the exponent of the power law K ~ k_p^(3 (i-1)), 3 by E I / L [-] (ours: one print of others had none)."""
    stiffness_scatter: float = 0.15
    """Of the logarithm of each joint's own stiffness about that law [-] (ours)."""
    mass: float = 0.1
    """Of the logarithm of the mass, where nothing was weighed [-] (ours: infill and silicone)."""
    center: float = 0.03
    """Of the centre of mass over the section's length [-] (ours: 1.6 mm at the base)."""
    friction: float = 0.15
    """Mean of the coefficient between cable and holes [-] (ours: 0.1 to 0.15 is reported of such pairs)."""
    friction_spread: float = 0.15
    """Of that coefficient [-]."""
    slack: float = 0.0
    """Mean of the cable that a winder takes in before it pulls [m]."""
    slack_spread: float = 8e-3
    """Of what all cables' slack has in common [m] (ours: two steps of the paper's protocol)."""
    slack_scatter: float = 2e-3
    """Of each cable's own slack about that [m] (ours)."""
    hole: float = 0.01
    """Of the holes' distance from the backbone over the face's half-width [-] (ours: 0.5 mm at the base)."""
    compliance: float = 2e-5
    """Mean of the compliance of winder and cable [m/N] (ours: 0.6 m of 1 mm braided polyethylene, and a motor that
    holds its position)."""
    compliance_spread: float = 2e-5
    """Of that [m/N] (ours)."""

    def __post_init__(self) -> None:
        means = {"friction": (0.0, 2.0), "slack": (-0.1, 0.1), "compliance": (0.0, _MOST_COMPLIANCE)}
        for part in fields(self):
            least, below = means.get(part.name, (1e-9 if part.name == "compliance_spread" else 1e-6, 10.0))
            check_number(f"prior.{part.name}", getattr(self, part.name), least=least, below=below)


_LEAST_SPREAD = 1e-5
"""Least standard deviation of a weighing over its mass [-] (ours: no scale is better, and the prior's covariance stays
regular)."""


@final
@dataclass(frozen=True, kw_only=True)
class Weighing:
    """A weighing: it alone, or a known load, separates stiffness from mass."""

    mass: float
    """Mass of all sections with the tip gripper, without the housing [kg]."""
    spread: float
    """Standard deviation of that [kg]."""

    def __post_init__(self) -> None:
        check_number("weighing.mass", self.mass, above=0.0, below=1e3)
        check_number("weighing.spread", self.spread, least=_LEAST_SPREAD * self.mass, below=1e3)


@final
@dataclass(frozen=True, kw_only=True)
class BenchStiffness:
    """Stiffness of one joint as measured on a bench."""

    joint: int
    """Joint, 1 at the base."""
    value: float
    """Stiffness [N m/rad]."""
    spread: float
    """Standard deviation of its logarithm [-]."""

    def __post_init__(self) -> None:
        check_count("bench.joint", self.joint, least=1, most=199)
        check_number("bench.value", self.value, above=0.0, below=1e6)
        check_number("bench.spread", self.spread, least=1e-6, below=1e3)


@final
@dataclass(frozen=True, kw_only=True)
class Gaussian:
    """Normal distribution of the parameter vector."""

    names: tuple[str, ...]
    """Name of each parameter."""
    mean: np.ndarray
    """Shape (n_parameter,)."""
    covariance: np.ndarray
    """Shape (n_parameter, n_parameter)."""

    @property
    def spread(self) -> np.ndarray:
        """Standard deviations, shape (n_parameter,)."""
        return np.sqrt(np.diag(self.covariance))


def name_parameters(design: TrunkDesign) -> tuple[str, ...]:
    """Name of each parameter, joints and cables counted from 1."""
    joints = (f"stiffness_{i + 1:02d}" for i in range(design.n_joint))
    cables = (f"slack_{c + 1}" for c in range(design.n_cable))
    return (*joints, "mass", "center", "friction", *cables, "hole", "give")


def build_prior(
    design: TrunkDesign, prior: Prior, weighing: Weighing | None = None, bench: tuple[BenchStiffness, ...] = ()
) -> Gaussian:
    """Prior of the parameter vector, conditioned on what was measured beside the recordings.

    Raises:
        ModelError: for a weighing more than a factor of four from the design's mass, a joint that the design has not,
            or a stiffness more than a factor of a hundred from the design's.
    """
    joints, cables = design.n_joint, design.n_cable
    along = np.log(design.scale[:-1])
    stiffness = (
        prior.stiffness_level**2
        + prior.stiffness_exponent**2 * np.outer(along, along)
        + prior.stiffness_scatter**2 * np.eye(joints)
    )
    slacks = [prior.slack_scatter] * cables
    rest = [prior.mass, prior.center, prior.friction_spread, *slacks, prior.hole, prior.compliance_spread]
    size = joints + len(rest)
    covariance = np.zeros((size, size))
    covariance[:joints, :joints] = stiffness
    covariance[range(joints, size), range(joints, size)] = np.square(rest)
    covariance[joints + 3 : size - 2, joints + 3 : size - 2] += prior.slack_spread**2
    mean = np.array([*[0.0] * joints, 0.0, 0.0, prior.friction, *[prior.slack] * cables, 0.0, prior.compliance])
    measured = [_read_bench(design, one) for one in bench]
    if weighing is not None:
        measured.append(_read_weighing(design, weighing))
    return _condition(Gaussian(names=name_parameters(design), mean=mean, covariance=covariance), measured)


def _condition(prior: Gaussian, measured: list[tuple[int, float, float]]) -> Gaussian:
    """The prior conditioned on independent measurements: index of the parameter, value and standard deviation.

    mean + G (y - H mean) and (1 - G H) C with the gain G = C H^T (H C H^T + R)^-1 (Kalman 1960).
    """
    if not measured:
        return prior
    at, values, spreads = (list(part) for part in zip(*measured, strict=True))
    both = prior.covariance[np.ix_(at, at)] + np.diag(np.square(spreads))
    gain = np.linalg.solve(both, prior.covariance[at]).T
    covariance = prior.covariance - gain @ prior.covariance[at]
    return replace(
        prior, mean=prior.mean + gain @ (np.array(values) - prior.mean[at]), covariance=(covariance + covariance.T) / 2
    )


def _read_weighing(design: TrunkDesign, weighing: Weighing) -> tuple[int, float, float]:
    ratio = weighing.mass / design.total_mass
    if not 0.25 < ratio < 4.0:
        given = f"{1e3 * weighing.mass:g} g weighed, the design has {1e3 * design.total_mass:g} g"
        raise ModelError(f"{given}; allowed: within a factor of four: weigh sections and gripper without the housing")
    return design.n_joint, math.log(ratio), weighing.spread / weighing.mass


def _read_bench(design: TrunkDesign, bench: BenchStiffness) -> tuple[int, float, float]:
    if bench.joint > design.n_joint:
        raise ModelError(f"the bench has joint {bench.joint}; allowed: 1 to {design.n_joint}, as the design")
    ratio = bench.value / float(design.joint_stiffness[bench.joint - 1])
    if not 0.01 < ratio < 100.0:
        raise ModelError(
            f"joint {bench.joint} has {bench.value:.3g} N m/rad on the bench, {ratio:.3g} times the design's; "
            "allowed: within a factor of 100: is it the same trunk?"
        )
    return bench.joint - 1, math.log(ratio), bench.spread


def keep_positive(names: tuple[str, ...], values: np.ndarray) -> np.ndarray:
    """The parameter vector with friction and compliance at 0 at least."""
    return np.where(np.isin(names, ("friction", "give")), np.maximum(values, 0.0), values)


def apply_parameters(design: TrunkDesign, values: np.ndarray) -> tuple[TrunkDesign, Winders]:
    """The design with a parameter vector, and its winders.

    The mass of the gripper, where the design has one, changes by the same factor as that of the sections.
    """
    joints, cables = design.n_joint, design.n_cable
    mass, center, friction = values[joints : joints + 3]
    slack, hole, compliance = values[joints + 3 : joints + 3 + cables], values[-2], values[-1]
    stiffness = design.joint_stiffness * np.exp(values[:joints])
    gripper = design.gripper
    changed = replace(
        design,
        joint=replace(design.joint, stiffness=tuple(stiffness.tolist())),
        cable=replace(
            design.cable, friction=max(float(friction), 0.0), hole_fraction=design.cable.hole_fraction + float(hole)
        ),
        mass=replace(
            design.mass, sections=tuple((design.section_mass * math.exp(mass)).tolist()),
            center_fraction=center_fraction(design) + float(center),
        ),
        gripper=None if gripper is None else replace(gripper, mass=gripper.mass * math.exp(mass)),
    )  # fmt: skip
    return changed, Winders(slack=np.array(slack), compliance=max(float(compliance), 0.0))


def center_fraction(design: TrunkDesign) -> float:
    """Centre of mass over the section's length [-]."""
    return float(design.section_center[0] / design.section_length[0])
