"""Bending by a dorsal cable: one shape against the same law with a matrix chain, a batch against NumPy arrays."""

from __future__ import annotations

import math

import numpy as np

from spiraltrunk.design import presets
from spiraltrunk.model import reference
from spiraltrunk.model.reference.constants import prepare, read_table
from spiraltrunk.workflows.bench.claim import Claim, one_core, time_in_turns

TILT = 0.4
"""Angle of the base axis below the horizontal [rad]."""

PULL = 0.05
"""Cable pulled in for the one shape [m]."""

COUNT = 100_000
"""Shapes of the batch."""

MOST = 0.1
"""Largest pull of the batch [m]; up to it no joint's share exceeds the open gaps nearer to the base."""


def measure_bend_single() -> Claim:
    """One whole shape against Algorithm 1, section ends by 4 x 4 matrices and cable lengths in NumPy, rest given [s].

    Both return section ends, joint angles and cable changes. Ours reuses the rest shape of the previous call, as the
    tilt is the same, and checks its arguments.
    """
    law = NumpyBending(TILT)
    ours, other = time_in_turns(lambda: reference.bend_dorsal(presets.PAPER, PULL, TILT), lambda: law.bend_one(PULL))
    return Claim(ours=ours, other=other, bar=10.0)


def measure_bend_batch() -> Claim:
    """Bends and section ends of 100,000 pulls on one core against the same law over arrays, rest given [s].

    Both write into memory of an earlier result with the same layout.
    """
    pulls = np.random.default_rng(0).uniform(0.0, MOST, COUNT)
    law = NumpyBending(TILT)
    ends = np.zeros((3, presets.PAPER.n_section, COUNT))
    own = reference.bend_dorsal_points(presets.PAPER, pulls, TILT)
    with one_core():
        ours, other = time_in_turns(
            lambda: reference.bend_dorsal_points(presets.PAPER, pulls, TILT, out=own),
            lambda: law.bend(pulls, ends),
        )
    return Claim(ours=ours, other=other, bar=10.0)


def chain_matrices(theta_0: float, bends: list[float], lengths: list[float]) -> np.ndarray:
    """Section ends from bends by 4 x 4 matrices, shape (n_section, 3) [m]."""
    pose = rotate_and_translate(-theta_0, lengths[0])
    ends = [pose[:3, 3]]
    for bend, length in zip(bends, lengths[1:], strict=True):
        pose = pose @ rotate_and_translate(bend, length)
        ends.append(pose[:3, 3])
    return np.array(ends)


def rotate_and_translate(bend: float, length: float) -> np.ndarray:
    """Rotation about z, then translation along x, shape (4, 4)."""
    c, s = np.cos(bend), np.sin(bend)
    return np.array([[c, -s, 0.0, c * length], [s, c, 0.0, s * length], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]])


class NumpyBending:
    """Algorithm 1 of the paper in NumPy, for pulls that leave joint 1 open.

    Args:
        theta_0: angle of the base axis below the horizontal [rad].
    """

    def __init__(self, theta_0: float) -> None:
        self.theta_0 = theta_0
        self.table = read_table(prepare(presets.PAPER).constants)
        turn = reference.rest(presets.PAPER, theta_0).joint_rotation
        sag = -np.arctan2(turn[:, 1, 0], turn[:, 0, 0])
        self.gap = self.table.diameter * np.sin((self.table.limit + sag) / 2)
        table = self.table
        columns = (table.portion[::-1], table.below[::-1], self.gap[::-1])
        self.shares = list(zip(*(column.tolist() for column in columns), strict=True))
        self.lengths = table.section_length.tolist()

    def bend_one(self, pull: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Section ends (n_section, 3) [m], joint angles (n_joint,) [rad] and cable changes (n_cable,) [m] for a pull.

        The recursion from joint to joint uses Python floats, which are faster than NumPy scalars; the rest uses arrays.
        """
        table, level, gaps = self.table, pull, []
        for portion, below, rest in self.shares:
            over = level * portion - rest
            gaps.append(max(-over, 0.0))
            level += max(over, 0.0) * below
        bend = table.limit - 2 * np.arcsin(np.array(gaps[::-1]) / table.diameter)
        c, s = np.cos(bend)[:, None], np.sin(bend)[:, None]
        x, y, z = table.beyond[..., 0], table.beyond[..., 1], table.beyond[..., 2]
        across = np.stack((c * x - s * y, s * x + c * y, z), axis=-1) - table.before
        change = table.total - np.sqrt((across * across).sum(axis=-1)).sum(axis=0)
        return chain_matrices(self.theta_0, bend.tolist(), self.lengths), np.abs(bend), change

    def bend(self, pull: np.ndarray, ends: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Section ends (n, n_section, 3) [m] and bends (n, n_joint) [rad] for pulls (n,) [m].

        ``ends`` (3, n_section, n) receives the former, with our layout and z = 0.
        """
        table = self.table
        level, gap = pull.copy(), np.empty((len(self.gap), len(pull)))
        for i in range(len(self.gap) - 1, -1, -1):
            over = level * table.portion[i] - self.gap[i]
            np.maximum(-over, 0.0, out=gap[i])
            level += np.maximum(over, 0.0, out=over) * table.below[i]
        bend = table.limit - 2 * np.arcsin(gap / table.diameter[:, None])
        angle = np.cumsum(bend, axis=0) - self.theta_0
        first = table.section_length[0]
        for k, (go, base) in enumerate(((np.cos, math.cos(-self.theta_0)), (np.sin, math.sin(-self.theta_0)))):
            ends[k, 0] = first * base
            ends[k, 1:] = first * base + np.cumsum(table.section_length[1:, None] * go(angle), axis=0)
        return ends.T, bend.T
