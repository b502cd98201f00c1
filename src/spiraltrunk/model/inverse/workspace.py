"""Workspace of the tip: equilibria over a grid of cable tensions."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import final

import numpy as np

from spiraltrunk.checks import check_count
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import ModelError
from spiraltrunk.field_docs import explain_fields
from spiraltrunk.model.inverse.start_table import least_tension
from spiraltrunk.model.kinematics.shape import Status
from spiraltrunk.model.statics import equilibrium
from spiraltrunk.model.statics.equilibrium import StaticsOptions
from spiraltrunk.model.statics.loads import Loads

__all__ = ["Workspace", "map"]

_MOST = 200_000
"""Largest number of equilibria of one map."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class Workspace:
    """Tip positions, one row an equilibrium; frame of `Shape`."""

    tension: np.ndarray
    """Tension of each cable, shape (s, n_cable) [N]."""
    pull: np.ndarray
    """Each cable pulled in since the straight trunk, shape (s, n_cable) [m]."""
    tip: np.ndarray
    """Tip, shape (s, 3) [m]."""
    n_shut: np.ndarray
    """Joints at their limit, shape (s,) [-]."""
    rest: np.ndarray
    """Section ends of the trunk with slack cables, shape (n_section, 3) [m]."""
    length: float
    """Length of the straight trunk [m]; no tip is farther from the base."""

    def in_plane(self, thickness: float) -> np.ndarray:
        """Which tips lie within half the ``thickness`` [m] of the plane z = 0, shape (s,) [bool]."""
        return np.abs(self.tip[:, 2]) <= thickness / 2


def map(
    design: TrunkDesign,
    *,
    levels: int = 20,
    theta_0: float = math.pi / 2,
    roll: float = 0.0,
    loads: Loads | None = None,
    options: StaticsOptions | None = None,
) -> Workspace:
    """Tips at all combinations of ``levels`` tensions per cable: 0, then logarithmic steps to the largest.

    Without friction. Equilibria that do not converge are left out; for the presets all converge.

    Args:
        design: the trunk.
        levels: tensions per cable, 2 or more.
        theta_0: angle of the base axis below the horizontal [rad].
        roll: rotation of the trunk about its base axis [rad].
        loads: loads besides its weight.
        options: options of the model.

    Raises:
        ModelError: for a batch of base poses or loads, or more than 200 000 combinations.
    """
    check_count("levels", levels, least=2, most=_MOST)
    if levels**design.n_cable > _MOST:
        raise ModelError(f"levels is {levels}; allowed: at most {int(_MOST ** (1 / design.n_cable))} for this design")
    most = design.cable.tension_max
    taut = [most] if levels == 2 else np.geomspace(least_tension(design), most, levels - 1)
    row = np.minimum(np.concatenate([[0.0], taut]), most)
    tension = np.stack(np.meshgrid(*[row] * design.n_cable, indexing="ij"), axis=-1)
    tension = tension.reshape(-1, design.n_cable)
    shape = equilibrium.solve(
        design, tension=tension, theta_0=theta_0, roll=roll, loads=loads, friction=0.0, options=options
    )
    found = shape.status != Status.NOT_CONVERGED
    return Workspace(
        tension=tension[found], pull=shape.cable_change[found], tip=shape.points[found, -1],
        n_shut=shape.is_shut[found].sum(axis=-1), rest=shape.points[0], length=design.length,
    )  # fmt: skip
