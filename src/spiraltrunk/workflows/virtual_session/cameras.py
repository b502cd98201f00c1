"""Played shapes as cameras would record them: marker noise, occlusions, poses held over, frames dropped."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import final

import numpy as np
from scipy.spatial.transform import Rotation

from spiraltrunk.calibration.predict_states import place_markers
from spiraltrunk.checks import check_number
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.mocap.recordings.take import Body, Marker, Take
from spiraltrunk.mocap.signal.registration import Motion
from spiraltrunk.model.kinematics.measured_shapes import compute_marker_offset
from spiraltrunk.workflows.virtual_session.play import Played
from spiraltrunk.workflows.virtual_session.synthetic_take import Rehearsal, rehearse_take

NAME = "virtual capture, not a measurement"
"""What every such take is called."""

PAPERS = (2, 4, *range(6, 19))
"""Sections with markers, from 1: fifteen, as many as the paper's, which does not say which (ours: all but three near
the base, which move the least)."""


@final
@dataclass(frozen=True, kw_only=True)
class FilmOptions:
    """How a run is recorded."""

    rate: float = 100.0
    """Frames per second [Hz]."""
    hold: float = 1.0
    """Time for which each shape is held [s]."""
    move: float = 0.5
    """Time from shape to shape [s]."""
    noise: float = 5e-4
    """Standard deviation of each coordinate of each marker in each frame [m]."""
    occluded: float = 0.05
    """Part of each track that is not seen, in gaps of `GAP` [-]."""
    held: float = 0.02
    """Part of each track whose last pose is held over instead [-]."""
    dropped: float = 0.005
    """Part of the frames that is missing altogether [-]."""
    sections: tuple[int, ...] = PAPERS
    """Sections with markers, from 1."""

    def __post_init__(self) -> None:
        for name in ("hold", "move"):
            check_number(name, getattr(self, name), least=0.05, below=60.0)
        for name in ("occluded", "held", "dropped"):
            check_number(name, getattr(self, name), least=0.0, below=0.5)

    @property
    def period(self) -> float:
        """Time from shape to shape as it comes out in whole frames [s]."""
        return (max(1, round(self.hold * self.rate)) + max(1, round(self.move * self.rate))) / self.rate


GAP = 0.15
"""How long an occlusion or a pose held over lasts [s]."""


def film(design: TrunkDesign, played: Played, seed: int, options: FilmOptions | None = None) -> Take:
    """A recording of a played run, in a frame of its own (y up), that says that it is virtual.

    Args:
        design: the trunk as its laboratory believes it to be: markers sit where the design has them.
        played: the run.
        seed: what noise, gaps and frame are drawn from.
        options: how it is recorded.
    """
    options = FilmOptions() if options is None else options
    draw = np.random.default_rng([9, seed])
    turn = Rotation.from_euler("yxz", [draw.uniform(-180, 180), *draw.normal(0.0, 0.5, 2)], degrees=True)
    frame = Motion(rotation=turn.as_matrix(), shift=draw.uniform(-1.0, 1.0, 3))
    rehearsal = Rehearsal(
        rate=options.rate, hold=options.hold, move=options.move, noise=options.noise, frame=frame,
        sections=options.sections, seed=int(draw.integers(2**32)),
    )  # fmt: skip
    points = place_markers(design, played.ends, compute_marker_offset(design))
    take = rehearse_take(design, points, played.rotation, played.plan.run.theta_0, rehearsal)
    spoiled = _spoil(take, draw, options)
    return replace(spoiled, source="virtual capture", name=NAME)


def _spoil(take: Take, draw: np.random.Generator, options: FilmOptions) -> Take:
    """Gaps, poses held over and missing frames."""
    count, length = len(take.frame), max(3, round(GAP * options.rate))
    bodies, markers = [], []
    for body in take.bodies:
        blank, held = (_spans(count, length, part, draw) for part in (options.occluded, options.held))
        if body.name == "base":
            blank[:] = False  # It is fixed and near the cameras.
        bodies.append(_spoil_body(body, blank, held))
        markers += [_spoil_marker(m, blank, held) for m in take.markers if m.name.startswith(f"{body.name}:")]
    kept = np.flatnonzero(draw.random(count) >= options.dropped)
    return replace(
        take, frame=take.frame[kept], time=take.time[kept], bodies=tuple(_cut_body(b, kept) for b in bodies),
        markers=tuple(replace(m, position=m.position[kept], is_stale=m.is_stale[kept]) for m in markers),
    )  # fmt: skip


def _spans(count: int, length: int, part: float, draw: np.random.Generator) -> np.ndarray:
    """Frames within spans that cover about this part, shape (count,) [bool]."""
    out = np.zeros(count, bool)
    for begin in draw.integers(1, count, draw.poisson(part * count / length)):
        out[begin : begin + length] = True
    return out


def _last_seen(held: np.ndarray) -> np.ndarray:
    """For each frame the one whose pose it shows, shape (count,) [-]."""
    index = np.arange(len(held))
    return np.maximum.accumulate(np.where(held, 0, index))


def _spoil_body(body: Body, blank: np.ndarray, held: np.ndarray) -> Body:
    shown = _last_seen(held)
    gone = blank[:, None]
    return replace(
        body, position=np.where(gone, np.nan, body.position[shown]),
        quaternion_wxyz=np.where(gone, np.nan, body.quaternion_wxyz[shown]),
        marker_error=np.where(blank, np.nan, body.marker_error[shown]), is_stale=held,
    )  # fmt: skip


def _spoil_marker(marker: Marker, blank: np.ndarray, held: np.ndarray) -> Marker:
    shown = np.where(blank[:, None], np.nan, marker.position[_last_seen(held)])
    return replace(marker, position=shown, is_stale=held)


def _cut_body(body: Body, kept: np.ndarray) -> Body:
    return replace(
        body, position=body.position[kept], quaternion_wxyz=body.quaternion_wxyz[kept],
        marker_error=body.marker_error[kept], is_stale=body.is_stale[kept],
    )  # fmt: skip
