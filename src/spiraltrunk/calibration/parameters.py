"""What a calibration may turn: stiffness joint by joint, mass and its centre, friction, slack, holes, give of winders.

Of each knob something is known before any recording, as a Gaussian: its mean and how far real prints are from it. What
a recording does not tell keeps that width, and is reported so.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from spiraltrunk.checks import check_count, check_number
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import ModelError

MOST_GIVE = 1e-2
"""Largest give of a winder that is reckoned with [m/N]: equilibria bear no more."""


@final
@dataclass(frozen=True, kw_only=True)
class Winders:
    """What lies between a winder's command and the cable's length, and is no part of a design."""

    slack: np.ndarray
    """Cable that each takes in before it pulls, shape (n_cable,) [m]."""
    give: float = 0.0
    """What each, with its cable, gives per tension [m/N]."""


@final
@dataclass(frozen=True, kw_only=True)
class Prior:
    """What is taken as known before the recordings: standard deviations about the design, and two means."""

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
    """Coefficient between cable and holes that is expected [-] (ours: 0.1 to 0.15 is told of such pairs)."""
    friction_spread: float = 0.15
    """Of that coefficient [-]."""
    slack: float = 0.0
    """Cable that a winder takes in before it pulls that is expected [m]."""
    slack_spread: float = 8e-3
    """Of what all cables' slack has in common [m] (ours: two steps of the paper's protocol)."""
    slack_scatter: float = 2e-3
    """Of each cable's own slack about that [m] (ours)."""
    hole: float = 0.01
    """Of the holes' distance from the backbone over the face's half-width [-] (ours: 0.5 mm at the base)."""
    give: float = 2e-5
    """What a winder with its cable gives per tension that is expected [m/N] (ours: 0.6 m of 1 mm braided polyethylene,
    and a motor that holds its position)."""
    give_spread: float = 2e-5
    """Of that [m/N] (ours)."""

    def __post_init__(self) -> None:
        for name in (
            "stiffness_level", "stiffness_exponent", "stiffness_scatter", "mass", "center", "friction_spread",
            "slack_spread", "slack_scatter", "hole",
        ):  # fmt: skip
            check_number(f"prior.{name}", getattr(self, name), least=1e-6, below=10.0)
        check_number("prior.give", self.give, least=0.0, below=MOST_GIVE)
        check_number("prior.give_spread", self.give_spread, least=1e-9, below=MOST_GIVE)
        check_number("prior.friction", self.friction, least=0.0, below=2.0)
        check_number("prior.slack", self.slack, least=-0.1, below=0.1)


@final
@dataclass(frozen=True, kw_only=True)
class Weighing:
    """What a scale said: it alone, or a known load, separates stiffness from mass."""

    mass: float
    """Mass of all sections with the tip gripper, without the housing [kg]."""
    spread: float
    """Standard deviation of that [kg]."""

    def __post_init__(self) -> None:
        check_number("weighing.mass", self.mass, above=0.0, below=1e3)
        check_number("weighing.spread", self.spread, above=0.0, below=1e3)


@final
@dataclass(frozen=True, kw_only=True)
class BenchStiffness:
    """What a bench said of one joint's stiffness."""

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
class Knobs:
    """Names, means and covariance of all knobs, in one order: joints, mass, centre, friction, slack, holes, give.

    Stiffnesses and mass are logarithms over the design's, so that they stay positive; friction and give are plain
    numbers, kept at or above 0; the others are differences from the design.
    """

    names: tuple[str, ...]
    """Name of each knob."""
    mean: np.ndarray
    """Where each is expected, shape (n_knob,)."""
    covariance: np.ndarray
    """Of that expectation, shape (n_knob, n_knob)."""

    @property
    def spread(self) -> np.ndarray:
        """Standard deviation of each before any recording, shape (n_knob,)."""
        return np.sqrt(np.diag(self.covariance))


def build_knobs(design: TrunkDesign, prior: Prior, weighing: Weighing | None) -> Knobs:
    """Knobs of a design, as far as they are known beforehand.

    Raises:
        ModelError: for a weighing that is more than a factor of four from the design's mass.
    """
    joints, cables = design.n_joint, design.n_cable
    along = np.log(design.scale[:-1])
    stiffness = (
        prior.stiffness_level**2
        + prior.stiffness_exponent**2 * np.outer(along, along)
        + prior.stiffness_scatter**2 * np.eye(joints)
    )
    mass, mass_spread = _expect_mass(design, prior, weighing)
    slacks = [prior.slack_scatter] * cables
    rest = [mass_spread, prior.center, prior.friction_spread, *slacks, prior.hole, prior.give_spread]
    size = joints + len(rest)
    covariance = np.zeros((size, size))
    covariance[:joints, :joints] = stiffness
    covariance[range(joints, size), range(joints, size)] = np.square(rest)
    covariance[joints + 3 : size - 2, joints + 3 : size - 2] += prior.slack_spread**2
    mean = np.array([*[0.0] * joints, mass, 0.0, prior.friction, *[prior.slack] * cables, 0.0, prior.give])
    return Knobs(names=name_knobs(design), mean=mean, covariance=covariance)


def learn_from_bench(design: TrunkDesign, knobs: Knobs, bench: tuple[BenchStiffness, ...]) -> Knobs:
    """The knobs as they are known after stiffnesses were measured one by one (Gaussian conditioning).

    Raises:
        ModelError: for a joint that the design has not, or a stiffness more than a factor of a hundred from its.
    """
    if not bench:
        return knobs
    apart = np.zeros(len(bench))
    for i, one in enumerate(bench):
        if one.joint > design.n_joint:
            raise ModelError(f"the bench has joint {one.joint}; allowed: 1 to {design.n_joint}, as the design")
        ratio = one.value / float(design.joint_stiffness[one.joint - 1])
        if not 0.01 < ratio < 100.0:
            raise ModelError(
                f"joint {one.joint} has {one.value:.3g} N m/rad on the bench, {ratio:.3g} times the design's; "
                "allowed: within a factor of 100: is it the same trunk?"
            )
        apart[i] = math.log(ratio)
    at = [one.joint - 1 for one in bench]
    both = knobs.covariance[np.ix_(at, at)] + np.diag([one.spread**2 for one in bench])
    gain = np.linalg.solve(both, knobs.covariance[at]).T
    covariance = knobs.covariance - gain @ knobs.covariance[at]
    return Knobs(
        names=knobs.names, mean=knobs.mean + gain @ (apart - knobs.mean[at]), covariance=(covariance + covariance.T) / 2
    )


def name_knobs(design: TrunkDesign) -> tuple[str, ...]:
    """Name of each knob, joints and cables counted from 1."""
    joints = (f"stiffness_{i + 1:02d}" for i in range(design.n_joint))
    cables = (f"slack_{c + 1}" for c in range(design.n_cable))
    return (*joints, "mass", "center", "friction", *cables, "hole", "give")


def keep_positive(names: tuple[str, ...], knobs: np.ndarray) -> np.ndarray:
    """The knobs with those that cannot be negative, friction and give, at 0 at least."""
    return np.where(np.isin(names, ("friction", "give")), np.maximum(knobs, 0.0), knobs)


def apply_knobs(design: TrunkDesign, knobs: np.ndarray) -> tuple[TrunkDesign, Winders]:
    """The design with the knobs turned so, and its winders.

    The gripper, where the design has one, weighs more by the same part as the sections.
    """
    joints, cables = design.n_joint, design.n_cable
    mass, center, friction = knobs[joints : joints + 3]
    slack, hole, give = knobs[joints + 3 : joints + 3 + cables], knobs[-2], knobs[-1]
    stiffness = design.joint_stiffness * np.exp(knobs[:joints])
    gripper = design.gripper
    turned = replace(
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
    return turned, Winders(slack=np.array(slack), give=max(float(give), 0.0))


def center_fraction(design: TrunkDesign) -> float:
    """Centre of mass over the section's length [-]."""
    return float(design.section_center[0] / design.section_length[0])


def _expect_mass(design: TrunkDesign, prior: Prior, weighing: Weighing | None) -> tuple[float, float]:
    """Mean and standard deviation of the logarithm of mass over the design's, by what is told and what was weighed."""
    if weighing is None:
        return 0.0, prior.mass
    ratio = weighing.mass / design.total_mass
    if not 0.25 < ratio < 4.0:
        told = f"{1e3 * weighing.mass:g} g weighed, the design has {1e3 * design.total_mass:g} g"
        raise ModelError(f"{told}; allowed: within a factor of four: weigh sections and gripper without the housing")
    spread = weighing.spread / weighing.mass
    trust = np.array([1 / prior.mass**2, 1 / spread**2])
    return float(trust[1] * math.log(ratio) / trust.sum()), float(trust.sum() ** -0.5)
