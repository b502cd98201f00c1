"""Quantities of one run over time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np

from spiraltrunk.model.kinematics.curl_front import compute_front


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Series:
    """Quantities of one run, sampled at the same n instants."""

    time: np.ndarray
    """Instants, increasing, shape (n,) with n >= 2 [s]."""
    phase_spans: tuple[tuple[str, float, float], ...]
    """Name, begin and end of each phase [-, s, s]."""
    cable_pull: np.ndarray
    """Cable pulled in since the straight trunk, shape (n, n_cable) [m]."""
    cable_tension: np.ndarray
    """Tension of each cable, shape (n, n_cable) [N]."""
    joint_bend: np.ndarray
    """Bend of each joint, base to tip, shape (n, n_joint) [rad]."""
    joint_limit: float
    """Bend at which neighbouring sections touch [rad]."""
    section_length: np.ndarray
    """Length of each section, base to tip, shape (n_joint + 1,) [m]."""
    object_height: np.ndarray
    """Height of the object's centre, shape (n,) [m]."""
    lift: tuple[float, float] | None
    """Heights from and to which the object is to be lifted; None where it is not lifted [m]."""
    grip_force: np.ndarray
    """Sum of the normal forces between trunk and object, shape (n,) [N]."""
    string_tension: np.ndarray
    """Sum of the tensions of the strings that carry the object before the grasp, shape (n,) [N]."""
    title: str
    """Title of the figures."""

    @property
    def front(self) -> np.ndarray:
        """Curled length from the tip over the trunk's length, shape (n,) [-]."""
        front = compute_front(self.joint_bend, self.section_length, self.joint_limit)
        return np.asarray(front / self.section_length.sum())
