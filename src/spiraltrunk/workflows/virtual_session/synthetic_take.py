"""Recordings made up from shapes: to rehearse a session and to test what reads one. Never a measurement."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np

from spiraltrunk.checks import check_number
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.mocap.recordings.take import SYNTHETIC, Body, Marker, Take, find_stale
from spiraltrunk.mocap.signal.registration import Motion
from spiraltrunk.model.kinematics.frames import base_orientation


@final
@dataclass(frozen=True, kw_only=True)
class Rehearsal:
    """How a made-up recording is taken."""

    rate: float = 100.0
    """Frames per second [Hz]."""
    hold: float = 1.5
    """Time for which each shape is held [s]."""
    move: float = 0.5
    """Time from shape to shape [s]."""
    noise: float = 2e-4
    """Standard deviation of each coordinate of each marker [m] (ours: a calibrated room has 0.1 to 0.3 mm)."""
    frame: Motion | None = None
    """From the model's frame to the cameras'; None leaves it."""
    sections: tuple[int, ...] = ()
    """Sections with markers, from 1; empty for all."""
    seed: int = 0
    """What the noise is drawn from."""

    def __post_init__(self) -> None:
        check_number("rate", self.rate, least=1.0, most=1e4)
        check_number("hold", self.hold, above=0.0, most=1e3)
        check_number("move", self.move, above=0.0, most=1e3)
        check_number("noise", self.noise, least=0.0, most=1.0)


def rehearse_take(
    design: TrunkDesign, points: np.ndarray, rotation: np.ndarray, theta_0: float, rehearsal: Rehearsal
) -> Take:
    """A recording in which the trunk goes from shape to shape and holds each.

    Args:
        design: the trunk.
        points: the measured points of all sections, shape (n, n_section, 3) [m].
        rotation: axes of all sections, shape (n, n_section, 3, 3) [-].
        theta_0: angle of the base axis below the horizontal [rad].
        rehearsal: how it is taken.
    """
    numbers = rehearsal.sections or tuple(range(1, design.n_section + 1))
    chosen = np.array(numbers) - 1
    share = _pace(len(points), rehearsal)
    draw = np.random.default_rng(rehearsal.seed)
    local = _edge(design)[chosen]
    markers = points[:, chosen, None] + np.einsum("nsij,smj->nsmi", rotation[:, chosen], local)
    base = base_orientation(theta_0)
    foot = np.broadcast_to(_corners(design.solid.radius) @ base.T, (len(points), 1, 3, 3))
    placed = _blend(np.concatenate([foot, markers], axis=1), share)
    if rehearsal.frame is not None:
        placed = rehearsal.frame.move(placed)
    placed = placed + draw.normal(0.0, rehearsal.noise, placed.shape)
    frame = np.arange(len(placed))
    names = ("base", *(f"section_{number:02d}" for number in numbers))
    layout = np.concatenate([_corners(design.solid.radius)[None], local])
    return Take(
        source="rehearsal", name="rehearsal, not a measurement", started="", rate=rehearsal.rate, frame=frame,
        time=frame / rehearsal.rate,
        bodies=tuple(_solve_body(name, placed[:, i], layout[i]) for i, name in enumerate(names)),
        markers=tuple(
            _see_marker(f"{name}:Marker{k + 1}", placed[:, i, k]) for i, name in enumerate(names) for k in range(3)
        ),
        comment=SYNTHETIC,
    )  # fmt: skip


def _pace(count: int, rehearsal: Rehearsal) -> np.ndarray:
    """Where in the row of shapes the trunk is at each frame, from 0 to count - 1, shape (n,) [-]."""
    held, moved = (max(1, round(time * rehearsal.rate)) for time in (rehearsal.hold, rehearsal.move))
    step = np.arange(1, moved + 1) / (moved + 1)
    parts = [np.concatenate([np.full(held, float(i)), i + step]) for i in range(count)]
    return np.concatenate(parts)[:-moved]


def _blend(shapes: np.ndarray, share: np.ndarray) -> np.ndarray:
    """Markers at each frame, on straight ways between the shapes."""
    before = np.minimum(share.astype(int), len(shapes) - 1)
    beyond = np.minimum(before + 1, len(shapes) - 1)
    part = (share - before).reshape(-1, *[1] * (shapes.ndim - 1))
    blended: np.ndarray = (1 - part) * shapes[before] + part * shapes[beyond]
    return blended


def _corners(radius: float) -> np.ndarray:
    """Three points round the x axis, the first dorsal, counted from y to z, shape (3, 3) [m]."""
    angle = 2 * np.pi / 3 * np.arange(3)
    return radius * np.stack([np.zeros(3), np.cos(angle), np.sin(angle)], axis=-1)


def _edge(design: TrunkDesign) -> np.ndarray:
    """Markers of each section about their centre, in the section's axes, shape (n_section, 3, 3) [m]."""
    return design.scale[:, None, None] * _corners(design.solid.radius)


def _solve_body(name: str, markers: np.ndarray, layout: np.ndarray) -> Body:
    """A rigid body by its markers: their centre, and the axes that fit them best."""
    center = markers.mean(axis=1)
    u, _, vt = np.linalg.svd(np.einsum("ki,nkj->nij", layout, markers - center[:, None]))
    turn = np.swapaxes(vt, -1, -2)
    turn[..., 2] *= np.sign(np.linalg.det(u) * np.linalg.det(vt))[:, None]
    rotation = turn @ np.swapaxes(u, -1, -2)
    from scipy.spatial.transform import Rotation

    quaternion = Rotation.from_matrix(rotation).as_quat()[:, [3, 0, 1, 2]]
    apart = np.linalg.norm(markers - center[:, None] - np.einsum("nij,kj->nki", rotation, layout), axis=-1)
    return Body(
        name=name, id=f"{name}-1", position=center, quaternion_wxyz=quaternion, marker_error=apart.mean(axis=1),
        is_stale=find_stale(np.hstack([center, quaternion])),
    )  # fmt: skip


def _see_marker(name: str, position: np.ndarray) -> Marker:
    return Marker(name=name, id=f"{name}-1", is_solved=False, position=position, is_stale=find_stale(position))
