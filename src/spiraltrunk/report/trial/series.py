"""One run as arrays over time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np

from spiraltrunk.errors import ShapeError
from spiraltrunk.model.kinematics.curl_front import compute_front

_AXES = {
    "time": 1,
    "cable_pull": 2,
    "cable_tension": 2,
    "joint_bend": 2,
    "object_height": 1,
    "grip_force": 1,
    "string_tension": 1,
}
"""Arrays and how many axes they have; time comes first."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Series:
    """Quantities of one run at the same instants, copied and read-only.

    Raises:
        ShapeError: where an array does not fit the others, or holds what is not finite.
    """

    time: np.ndarray
    """Instants, increasing, shape (n,) with n >= 2 [s]."""
    phase_spans: tuple[tuple[str, float, float], ...]
    """Name of each phase and the times at which it begins and ends [-, s, s]."""
    cable_pull: np.ndarray
    """Cable pulled in since the straight trunk, shape (n, n_cable) [m]."""
    cable_tension: np.ndarray
    """Tension of each cable, shape (n, n_cable) [N]."""
    joint_bend: np.ndarray
    """Bend of each joint, the base's first, shape (n, n_joint) [rad]."""
    joint_limit: float
    """Bend at which neighbouring sections touch [rad]."""
    section_length: np.ndarray
    """Length of each section, the base's first, shape (n_joint + 1,) [m]."""
    object_height: np.ndarray
    """Height of the object's centre, shape (n,) [m]."""
    lift: tuple[float, float] | None
    """Heights from which and to which it is to be lifted; None where it is not [m]."""
    grip_force: np.ndarray
    """Sum of the normal forces between trunk and object, shape (n,) [N]."""
    string_tension: np.ndarray
    """Sum of the tensions of the strings that carry the object before the grasp, shape (n,) [N]."""
    title: str
    """What the run was, for the head of its pictures."""

    def __post_init__(self) -> None:
        for name, axes in _AXES.items():
            object.__setattr__(self, name, _read(name, getattr(self, name), axes, n=len(np.atleast_1d(self.time))))
        if len(self.time) < 2 or not (np.diff(self.time) > 0).all():
            raise ShapeError(f"time has {len(self.time)} instants; allowed: at least 2, each later than the one before")
        if self.cable_tension.shape != self.cable_pull.shape:
            raise ShapeError(
                f"cable_tension has shape {self.cable_tension.shape}; allowed: cable_pull's, {self.cable_pull.shape}"
            )
        if not (np.isfinite(self.joint_limit) and self.joint_limit > 0):
            raise ShapeError(f"joint_limit is {self.joint_limit}; allowed: finite, > 0 rad")
        object.__setattr__(self, "section_length", _read_lengths(self.section_length, self.n_joint))
        if self.lift is not None and not np.isfinite(self.lift).all():
            raise ShapeError(f"lift is {self.lift}; allowed: None or finite")
        for phase, begin, end in self.phase_spans:
            if not (np.isfinite([begin, end]).all() and begin <= end):
                raise ShapeError(f"phase {phase} spans {begin} to {end} s; allowed: finite, begin <= end")

    @property
    def n_cable(self) -> int:
        """Number of cables."""
        return self.cable_pull.shape[1]

    @property
    def n_joint(self) -> int:
        """Number of joints."""
        return self.joint_bend.shape[1]

    @property
    def front(self) -> np.ndarray:
        """How much of the trunk is curled, counted from the tip, over its length, shape (n,) [-]."""
        front = compute_front(self.joint_bend, self.section_length, self.joint_limit)
        return np.asarray(front / self.section_length.sum())


def _read_lengths(values: object, n_joint: int) -> np.ndarray:
    """A read-only copy of the sections' lengths."""
    length = _read("section_length", values, 1, n=n_joint + 1, like="one more than there are joints")
    if not (length > 0).all():
        raise ShapeError(f"section_length is {float(length.min()):g} m at least; allowed: > 0 m")
    return length


def _read(name: str, values: object, axes: int, *, n: int, like: str = "as time") -> np.ndarray:
    """A read-only copy in floating point, with its first axis of length n."""
    try:
        array = np.array(values, dtype=float)
    except (TypeError, ValueError):
        raise ShapeError(f"{name} is not an array of numbers; allowed: {_shape(axes, n, like)}") from None
    if array.ndim != axes or len(array) != n or 0 in array.shape:
        raise ShapeError(f"{name} has shape {array.shape}; allowed: {_shape(axes, n, like)}")
    if not np.isfinite(array).all():
        raise ShapeError(f"{name} holds what is not finite; allowed: finite numbers")
    array.setflags(write=False)
    return array


def _shape(axes: int, n: int, like: str) -> str:
    return f"({n},), {like}" if axes == 1 else f"({n}, at least 1), {like}"
