"""A trunk as it might have come out of the printer: off its design by so much, at random."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import final

import numpy as np

from spiraltrunk.calibration.parameters import Prior, Winders, apply_parameters
from spiraltrunk.checks import check_number
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.model.statics.pull_sequences import carry_gripper


@final
@dataclass(frozen=True, kw_only=True)
class WorldOptions:
    """How far a trunk is off its design; signs are drawn."""

    stiffness: float = 0.20
    """All joints' stiffness, up or down, over the design's [-]."""
    stiffness_scatter: float = 0.15
    """Standard deviation of the logarithm of each joint's own stiffness [-]."""
    mass: float = 0.10
    """Mass, up or down, over the design's [-]."""
    center: float = 0.03
    """Standard deviation of the centre of mass over the section's length [-]."""
    friction: float = 0.2
    """Coefficient between cables and holes [-]."""
    slack: float = 5e-3
    """Cable that each winder takes in before it pulls [m]."""
    hole: float = 0.01
    """Standard deviation of the holes' distance from the backbone over the face's half-width [-]."""
    compliance: float = 1e-5
    """Lengthening of each winder with its cable per tension [m/N] (ours: 0.6 mm at 60 N)."""
    sag: float = 0.0
    """Standard deviation of the bends, about both axes, in which the joints were printed [rad]."""

    def __post_init__(self) -> None:
        for name in ("stiffness", "mass"):
            check_number(name, getattr(self, name), least=0.0, below=0.9)
        for name in ("stiffness_scatter", "center", "friction", "hole", "sag"):
            check_number(name, getattr(self, name), least=0.0, below=1.0)
        check_number("slack", self.slack, least=0.0, below=0.05)
        check_number("compliance", self.compliance, least=1e-6, below=1e-3)


@final
@dataclass(frozen=True, kw_only=True)
class World:
    """One such trunk."""

    seed: int
    """What it was drawn from."""
    design: TrunkDesign
    """What it is, the gripper's mass in the last section, as the models have it."""
    values: np.ndarray
    """Its parameter vector, as of `calibration.parameters`."""
    winders: Winders
    """Slack and compliance of its winders."""
    sag: np.ndarray
    """Bends about y and z in which the joints were printed, shape (n_joint, 2) [rad]."""


def draw_world(design: TrunkDesign, seed: int, options: WorldOptions | None = None) -> World:
    """A trunk off ``design``; the same seed, the same trunk.

    Raises:
        DesignError: where the trunk cannot be.
    """
    options = WorldOptions() if options is None else options
    draw = np.random.default_rng([7, seed])
    joints, cables = design.n_joint, design.n_cable
    level = math.log1p(options.stiffness * draw.choice([-1.0, 1.0]))
    stiffness = level + options.stiffness_scatter * draw.standard_normal(joints)
    mass = math.log1p(options.mass * draw.choice([-1.0, 1.0]))
    center, hole = options.center * draw.standard_normal(), options.hole * draw.standard_normal()
    values = np.array([*stiffness, mass, center, options.friction, *[options.slack] * cables, hole, options.compliance])
    true, winders = apply_parameters(carry_gripper(design), values)
    sag = options.sag * draw.standard_normal((joints, 2))
    return World(seed=seed, design=true, values=values, winders=winders, sag=sag)


def weigh(design: TrunkDesign, world: World, share: float = 0.01) -> tuple[float, float]:
    """What a scale would say of the trunk, and its standard deviation, a share of the mass [kg]."""
    true = float(world.design.section_mass.sum())
    spread = share * design.total_mass
    return true + spread * float(np.random.default_rng([8, world.seed]).standard_normal()), spread


def expected(options: WorldOptions) -> Prior:
    """What is known of such trunks beforehand, as wide as they are drawn."""
    return Prior(
        stiffness_scatter=max(options.stiffness_scatter, 0.02), center=max(options.center, 1e-3),
        hole=max(options.hole, 1e-3),
    )  # fmt: skip
