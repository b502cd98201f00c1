"""The trunk that the tab shows: its pulls, its base, its equilibrium and the paper's model beside it."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, final

import numpy as np

from spiraltrunk.design import TrunkDesign

if TYPE_CHECKING:
    from spiraltrunk.model.kinematics.shape import Shape
    from spiraltrunk.model.statics.paper_pull import PaperShape

_QUICK_TRIES = 3
"""Starts of the inverse model while the tip is dragged [-]; when it is let go, its own number."""


@final
class TrunkState:
    """Pulls and base of a trunk, and what the models say of them. Its models load Numba, so they are loaded in use."""

    def __init__(self, design: TrunkDesign) -> None:
        self.design = design
        self.pull = np.full(design.n_cable, -design.cable_stroke)
        """Each cable pulled in since the straight trunk, negative for let out, shape (n_cable,) [m]."""
        self.theta_0 = math.pi / 2
        """Angle of the base axis below the horizontal [rad]."""
        self.roll = 0.0
        """Rotation about the base axis [rad]."""
        self.shape: Shape | None = None
        """The equilibrium; None before the first solution."""
        self.rest: Shape | None = None
        """The equilibrium with slack cables at the same base."""
        self.paper: PaperShape | None = None
        """What the paper's model says of the same pulls."""

    @property
    def tip(self) -> np.ndarray:
        """Tip of the equilibrium, or of the straight trunk before there is one, shape (3,) [m]."""
        if self.shape is not None:
            return np.array(self.shape.points[-1])
        return self.design.length * np.array([math.cos(self.theta_0), -math.sin(self.theta_0), 0.0])

    def turn(self, theta_0: float, roll: float) -> None:
        """Turn the base [rad]; the next solution goes on from the present shape."""
        self.theta_0, self.roll = float(theta_0), float(roll)
        self.rest = None

    def solve(self) -> None:
        """Solve for the pulls from the present shape on; from rest where that does not converge."""
        from spiraltrunk.model.kinematics.shape import Status
        from spiraltrunk.model.statics.pull_sequences import wind_cables

        base = (self.theta_0, self.roll)
        found = wind_cables(self.design, self.pull, *base, start=self.shape)
        if found.status == Status.NOT_CONVERGED and self.shape is not None:
            found = wind_cables(self.design, self.pull, *base)
        self.shape = found

    def restart(self) -> None:
        """Forget the present shape: the next solution starts from rest."""
        self.shape = None

    def compare(self) -> None:
        """Compute the paper's model for the same pulls."""
        from spiraltrunk.model.statics.paper_pull import compute_paper_shape
        from spiraltrunk.model.statics.pull_sequences import wind_cables

        assert self.shape is not None
        if self.rest is None:
            slack = np.full(self.design.n_cable, -self.design.cable_stroke)
            self.rest = wind_cables(self.design, slack, self.theta_0, self.roll)
        self.paper = compute_paper_shape(self.design, self.shape, self.rest, self.theta_0, self.roll)

    def reach(self, target: np.ndarray, *, is_final: bool) -> float:
        """Bring the tip as near to a target (3,) [m] as the cables can, by the inverse model without friction.

        Where the design has friction, the cables are then wound to the same lengths with it.

        Args:
            target: place in the frame of `Shape`.
            is_final: whether to search from as many starts as the inverse model does by itself.

        Returns:
            The distance left [m].
        """
        from spiraltrunk.model import inverse
        from spiraltrunk.model.statics.pull_sequences import carry_gripper, wind_cables

        options = inverse.InverseOptions() if is_final else inverse.InverseOptions(tries=_QUICK_TRIES)
        base = (self.theta_0, self.roll)
        solution = inverse.solve(
            carry_gripper(self.design), target, theta_0=base[0], roll=base[1], friction=0.0, options=options
        )
        self.pull = np.array(solution.pull)
        has_friction = self.design.cable.friction > 0
        self.shape = wind_cables(self.design, self.pull, *base) if has_friction else solution.shape
        return float(np.linalg.norm(self.shape.points[-1] - target))
