"""A printed trunk: a design with random deviations."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import final

import numpy as np

from spiraltrunk.calibration.parameters import Prior, Winders, apply_parameters
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.field_docs import explain_fields
from spiraltrunk.model.statics.pull_sequences import carry_gripper


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class PrintOptions:
    """Deviations of printed trunks from their design; signs are random."""

    stiffness: float = 0.20
    """Common relative deviation of all joints' stiffness [-]."""
    stiffness_scatter: float = 0.15
    """Standard deviation of the logarithm of each joint's own stiffness [-]."""
    mass: float = 0.10
    """Relative deviation of the mass [-]."""
    center: float = 0.03
    """Standard deviation of the centre of mass over the section's length [-]."""
    friction: float = 0.2
    """Coefficient between cables and holes [-]."""
    slack: float = 5e-3
    """Length that each winder takes in before its cable is taut [m]."""
    hole: float = 0.01
    """Standard deviation of the holes' distance from the backbone over the face's half-width [-]."""
    compliance: float = 1e-5
    """Compliance of each winder with its cable [m/N] (ours: 0.6 mm at 60 N)."""
    sag: float = 0.0
    """Standard deviation of the joints' rest angles about both axes [rad]."""


@final
@dataclass(frozen=True, kw_only=True)
class PrintedTrunk:
    """One printed trunk."""

    seed: int
    """Seed that it was drawn from."""
    design: TrunkDesign
    """Its true design, the gripper's mass in the last section, as in the models."""
    values: np.ndarray
    """Its calibration parameters, in the order of `calibration.parameters.name_parameters`."""
    winders: Winders
    """Slack and compliance of its winders."""
    sag: np.ndarray
    """Rest angles of the joints about y and z, shape (n_joint, 2) [rad]."""


def draw_printed_trunk(design: TrunkDesign, seed: int, options: PrintOptions | None = None) -> PrintedTrunk:
    """Draw a printed trunk; it is determined by the seed.

    Raises:
        DesignError: where the deviations make an impossible trunk.
    """
    options = PrintOptions() if options is None else options
    draw = np.random.default_rng([7, seed])
    joints, cables = design.n_joint, design.n_cable
    level = math.log1p(options.stiffness * draw.choice([-1.0, 1.0]))
    stiffness = level + options.stiffness_scatter * draw.standard_normal(joints)
    mass = math.log1p(options.mass * draw.choice([-1.0, 1.0]))
    center, hole = options.center * draw.standard_normal(), options.hole * draw.standard_normal()
    values = np.array([*stiffness, mass, center, options.friction, *[options.slack] * cables, hole, options.compliance])
    true, winders = apply_parameters(carry_gripper(design), values)
    sag = options.sag * draw.standard_normal((joints, 2))
    return PrintedTrunk(seed=seed, design=true, values=values, winders=winders, sag=sag)


def weigh(design: TrunkDesign, trunk: PrintedTrunk, share: float = 0.01) -> tuple[float, float]:
    """Mass of the trunk by a scale, and its standard deviation, a share of the designed mass [kg]."""
    spread = share * design.total_mass
    error = spread * float(np.random.default_rng([8, trunk.seed]).standard_normal())
    return float(trunk.design.section_mass.sum()) + error, spread


def build_print_prior(options: PrintOptions) -> Prior:
    """A prior as wide as the distribution of the printed trunks."""
    return Prior(
        stiffness_scatter=max(options.stiffness_scatter, 0.02), center=max(options.center, 1e-3),
        hole=max(options.hole, 1e-3),
    )  # fmt: skip
