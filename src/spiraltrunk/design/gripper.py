"""The tip gripper: fingers around the tip, each a spiral of its own, opened and closed by two cable groups.

Source: "Grasping by Spiraling", Results ("Soft Manipulator Design") and Methods ("Hardware Fabrication"): three fingers
120 deg apart, b = 0.618 (golden ratio), 60 deg per phalanx, objects up to about 40 mm. Lengths and widths of the
fingers are not published: ours follow the spiral's ratio and fit a 40 mm ball.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import final

import numpy as np

from spiraltrunk.checks import Range, check_count, check_number, check_range
from spiraltrunk.field_docs import explain_fields

SCALES = Range(least=1.0, most=2.0)
"""Finger scales on a given trunk [-] (ours): at 2 the fingers stand 13 mm off the axis, beyond the paper's tip of 10.6
mm, and close with 32 N."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class GripperDesign:
    """Fingers at the tip; phalanx j is k_p^(j-1) times the first, k_p = exp(-b delta_theta)."""

    n_finger: int = 3
    """Number of fingers, evenly spaced about the axis, the first one dorsal (paper: 3)."""
    b: float = 0.618
    """Growth of the finger's spiral per radian [-] (paper: the golden ratio)."""
    delta_theta: float = math.pi / 3
    """Angle of the finger's spiral per phalanx, also the limit of each finger joint [rad] (paper: 60 deg)."""
    n_phalanx: int = 2
    """Number of phalanges of a finger (ours: two bends of 60 deg close a finger)."""
    finger_length: float = 0.038
    """Length of a straight finger [m] (ours: a quarter turn round 40 mm plus half the last phalanx)."""
    finger_width: float = 0.010
    """Thickness of a finger at its base [m] (ours)."""
    mount_radius: float = 0.0065
    """Distance of the finger bases from the axis [m] (ours: inside the 21.3 mm tip)."""
    mass: float = 0.0032
    """Mass of the whole gripper [kg] (authors' code: 3.2 g)."""
    stiffness: float = 0.02
    """Bending stiffness of a finger's first joint [N m/rad], then k_p^3 a joint (ours)."""
    tension_max: float = 8.0
    """Largest tension of a cable group [N] (ours)."""
    n_leg: int = 1
    """Legs of each cable group beside the trunk's solid joints [-]: 1 runs on one side of the axis, 2 on opposite sides
    with half the tension each, which does not bend the trunk (ours)."""

    def __post_init__(self) -> None:
        check_count("gripper.n_finger", self.n_finger, least=2, most=8)
        check_count("gripper.n_phalanx", self.n_phalanx, least=1, most=8)
        check_number("gripper.b", self.b, above=0.0, below=2.0)
        check_number("gripper.delta_theta", self.delta_theta, least=1e-4, below=math.pi / 2)
        for name in ("finger_length", "finger_width"):
            check_number(f"gripper.{name}", getattr(self, name), least=1e-5, below=10.0)
        for name in ("mass", "stiffness", "tension_max"):
            check_number(f"gripper.{name}", getattr(self, name), least=1e-12, below=1e4)
        check_number("gripper.mount_radius", self.mount_radius, least=0.0, below=10.0)
        check_count("gripper.n_leg", self.n_leg, least=1, most=2)

    @property
    def k_p(self) -> float:
        """Ratio of neighbouring phalanges exp(-b delta_theta) [-]."""
        return math.exp(-self.b * self.delta_theta)

    @cached_property
    def phalanx_length(self) -> np.ndarray:
        """Lengths of a finger's phalanges, base first, shape (n_phalanx,) [m]."""
        shares = self.k_p ** np.arange(self.n_phalanx)
        return self.finger_length * shares / shares.sum()

    @cached_property
    def phalanx_width(self) -> np.ndarray:
        """Thicknesses of a finger's phalanges, base first, at least a quarter of the first, shape (n_phalanx,) [m]."""
        return self.finger_width * np.maximum(self.k_p ** np.arange(self.n_phalanx), 0.25)

    @cached_property
    def joint_stiffness(self) -> np.ndarray:
        """Stiffness of a finger's joints, base first, shape (n_phalanx,) [N m/rad]."""
        return self.stiffness * self.k_p ** (3 * np.arange(self.n_phalanx))

    def scaled(self, factor: float) -> GripperDesign:
        """The same gripper ``factor`` times as large [-], of the same material."""
        check_number("gripper scale", factor, above=0.0, below=1e6)
        return replace(
            self,
            finger_length=factor * self.finger_length,
            finger_width=factor * self.finger_width,
            mount_radius=factor * self.mount_radius,
            mass=factor**3 * self.mass,
            stiffness=factor**3 * self.stiffness,
            tension_max=factor**2 * self.tension_max,
        )

    def enlarged(self, scale: float) -> GripperDesign:
        """The gripper of a larger finger scale on the same trunk: `scaled`, with cables of two legs above a scale of 1.

        Raises:
            DesignError: for a scale outside of `SCALES`.
        """
        check_range("gripper.scale", scale, SCALES)
        return self if scale == 1.0 else replace(self.scaled(scale), n_leg=2)

    @property
    def grasp_width(self) -> float:
        """Largest width that the fingers enclose [m]: all but half of the last phalanx spans a quarter turn."""
        return float(self.finger_length - self.phalanx_length[-1] / 2) * 4 / math.pi


STRAND_LEVER = 0.4
"""Distance of a strand from the joint's axis over the phalanx's width [-] (ours: just under the surface)."""
