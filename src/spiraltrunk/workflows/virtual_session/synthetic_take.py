"""Synthetic takes: recordings computed from shapes, to rehearse a session and to test readers. Not measurements."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np
from scipy.spatial.transform import Rotation

from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import ModelError
from spiraltrunk.field_docs import explain_fields
from spiraltrunk.mocap.recordings.take import SYNTHETIC, Body, Marker, Take
from spiraltrunk.mocap.signal.registration import Motion
from spiraltrunk.model.kinematics.frames import base_orientation


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class CameraOptions:
    """How a synthetic take is recorded."""

    rate: float = 100.0
    """Frames per second [Hz]."""
    hold: float = 1.5
    """Time for which each shape is held [s]."""
    move: float = 0.5
    """Time from shape to shape [s]."""
    noise: float = 2e-4
    """Standard deviation of each coordinate of each marker [m] (ours: a calibrated room has 0.1 to 0.3 mm)."""
    occluded: float = 0.0
    """Share of each track that is not seen [-]."""
    held: float = 0.0
    """Share of each track in which the last pose is repeated [-]."""
    dropped: float = 0.0
    """Share of the frames that is missing [-]."""
    frame: Motion | None = None
    """From the model's frame to the cameras'; None is the identity."""
    sections: tuple[int, ...] = ()
    """Sections with markers, from 1; empty for all."""
    seed: int = 0
    """Seed of the noise."""

    @property
    def hold_frames(self) -> int:
        """Frames for which each shape is held."""
        return max(1, round(self.hold * self.rate))

    @property
    def move_frames(self) -> int:
        """Frames from shape to shape."""
        return max(1, round(self.move * self.rate))

    @property
    def period(self) -> float:
        """Time from shape to shape, rounded to frames [s]."""
        return (self.hold_frames + self.move_frames) / self.rate


def build_synthetic_take(
    design: TrunkDesign, points: np.ndarray, rotation: np.ndarray, theta_0: float, options: CameraOptions
) -> Take:
    """A recording, without occlusions, in which the trunk moves from shape to shape and holds each.

    Args:
        design: the trunk.
        points: the measured points of all sections, shape (n, n_section, 3) [m].
        rotation: axes of all sections, shape (n, n_section, 3, 3) [-].
        theta_0: angle of the base axis below the horizontal [rad].
        options: how it is recorded.

    Raises:
        ModelError: for markers on a section that the design lacks.
    """
    numbers = options.sections or tuple(range(1, design.n_section + 1))
    if not 1 <= min(numbers) <= max(numbers) <= design.n_section:
        raise ModelError(f"sections are {numbers}; allowed: 1 to {design.n_section}, as the design has")
    chosen = np.array(numbers) - 1
    corners = _corners(design.solid.radius)
    local = design.scale[chosen, None, None] * corners
    markers = points[:, chosen, None] + np.einsum("nsij,smj->nsmi", rotation[:, chosen], local)
    base = np.broadcast_to(corners @ base_orientation(theta_0).T, (len(points), 1, 3, 3))
    placed = _interpolate(np.concatenate([base, markers], axis=1), options)
    if options.frame is not None:
        placed = options.frame.move(placed)
    placed = placed + np.random.default_rng(options.seed).normal(0.0, options.noise, placed.shape)
    frame = np.arange(len(placed))
    names = ("base", *(f"section_{number:02d}" for number in numbers))
    layout = np.concatenate([corners[None], local])
    return Take(
        source="synthetic", name=SYNTHETIC, started="", rate=options.rate, frame=frame, time=frame / options.rate,
        bodies=tuple(_solve_body(name, placed[:, i], layout[i]) for i, name in enumerate(names)),
        markers=tuple(
            _build_marker(f"{name}:Marker{k + 1}", placed[:, i, k]) for i, name in enumerate(names) for k in range(3)
        ),
        comment=SYNTHETIC,
    )  # fmt: skip


def _interpolate(shapes: np.ndarray, options: CameraOptions) -> np.ndarray:
    """Markers at each frame: every shape held, then moved to the next along straight lines."""
    step = np.arange(1, options.move_frames + 1) / (options.move_frames + 1)
    parts = [np.concatenate([np.full(options.hold_frames, float(i)), i + step]) for i in range(len(shapes))]
    index = np.concatenate(parts)[: -options.move_frames]
    before = np.minimum(index.astype(int), len(shapes) - 1)
    after = np.minimum(before + 1, len(shapes) - 1)
    part = (index - before).reshape(-1, *[1] * (shapes.ndim - 1))
    between: np.ndarray = (1 - part) * shapes[before] + part * shapes[after]
    return between


def _corners(radius: float) -> np.ndarray:
    """Three points around the x axis, the first dorsal, numbered from y to z, shape (3, 3) [m]."""
    angle = 2 * np.pi / 3 * np.arange(3)
    return radius * np.stack([np.zeros(3), np.cos(angle), np.sin(angle)], axis=-1)


def _solve_body(name: str, markers: np.ndarray, layout: np.ndarray) -> Body:
    """A rigid body from its markers: their centre, and the least-squares axes (Kabsch)."""
    center = markers.mean(axis=1)
    u, _, vt = np.linalg.svd(np.einsum("ki,nkj->nij", layout, markers - center[:, None]))
    turn = np.swapaxes(vt, -1, -2)
    turn[..., 2] *= np.sign(np.linalg.det(u) * np.linalg.det(vt))[:, None]
    rotation = turn @ np.swapaxes(u, -1, -2)
    quaternion = Rotation.from_matrix(rotation).as_quat()[:, [3, 0, 1, 2]]
    residual = np.linalg.norm(markers - center[:, None] - np.einsum("nij,kj->nki", rotation, layout), axis=-1)
    return Body(
        name=name, id=f"{name}-1", position=center, quaternion_wxyz=quaternion, marker_error=residual.mean(axis=1)
    )


def _build_marker(name: str, position: np.ndarray) -> Marker:
    return Marker(name=name, id=f"{name}-1", is_solved=False, position=position)
