"""Simulated cameras: marker noise, occlusions, held poses and dropped frames."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from spiraltrunk.calibration.predict_states import place_markers
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import ModelError
from spiraltrunk.mocap.recordings.take import Body, Marker, Take
from spiraltrunk.mocap.session.sections import FEWEST
from spiraltrunk.mocap.signal.registration import Motion
from spiraltrunk.model.kinematics.measured_shapes import compute_marker_offset
from spiraltrunk.workflows.virtual_session.simulate import SimulatedRun
from spiraltrunk.workflows.virtual_session.synthetic_take import CameraOptions, build_synthetic_take

NAME = "virtual session, not a measurement"
"""Take name of a virtual session."""

PAPERS = (2, 4, *range(6, 19))
"""Sections with markers, from 1: fifteen, as many as the paper's, which does not say which (ours: all but three near
the base, which move the least). Shorter trunks have markers on those of them that they have."""

CAMERAS = CameraOptions(hold=1.0, noise=5e-4, occluded=0.05, held=0.02, dropped=0.005, sections=PAPERS)
"""Cameras of a virtual session."""

GAP = 0.15
"""Length of an occlusion or a held pose [s]."""


def select_sections(design: TrunkDesign, options: CameraOptions = CAMERAS) -> tuple[int, ...]:
    """Sections of the options that the design has, from 1.

    Raises:
        ModelError: where they are too few to be evaluated.
    """
    numbers = range(1, design.n_section + 1)
    chosen = tuple(number for number in options.sections or numbers if number in numbers)
    if len(chosen) < FEWEST:
        marked = ", ".join(map(str, chosen)) or "none"
        raise ModelError(
            f"the design {design.name!r} has {design.n_section} sections, with markers on {marked}; allowed in a "
            f"virtual session: markers on {FEWEST} or more"
        )
    return chosen


def record_run(
    design: TrunkDesign, run: SimulatedRun, seed: int | tuple[int, ...], options: CameraOptions = CAMERAS
) -> Take:
    """A synthetic recording of a run, in a random frame (y up).

    Args:
        design: the trunk as designed: markers are on the designed section edges.
        run: the run.
        seed: seed of noise, gaps and frame, one number or several.
        options: how it is recorded; its frame and seed are replaced, sections that the design lacks left out.

    Raises:
        ModelError: where fewer than three sections have markers.
    """
    draw = np.random.default_rng([9, *((seed,) if isinstance(seed, int) else seed)])
    turn = Rotation.from_euler("yxz", [draw.uniform(-180, 180), *draw.normal(0.0, 0.5, 2)], degrees=True)
    frame = Motion(rotation=turn.as_matrix(), shift=draw.uniform(-1.0, 1.0, 3))
    sections = select_sections(design, options)
    options = replace(options, frame=frame, seed=int(draw.integers(2**32)), sections=sections)
    points = place_markers(design, run.ends, compute_marker_offset(design))
    take = build_synthetic_take(design, points, run.rotation, run.schedule.run.theta_0, options)
    return replace(_degrade(take, draw, options), source="virtual session", name=NAME)


def _degrade(take: Take, draw: np.random.Generator, options: CameraOptions) -> Take:
    """Add occlusions and held poses, and drop frames."""
    count, length = len(take.frame), max(3, round(GAP * options.rate))
    shown: dict[str, tuple[np.ndarray, np.ndarray]] = {}
    for body in take.bodies:
        blank, held = (_draw_spans(count, length, share, draw) for share in (options.occluded, options.held))
        if body.name == "base":
            blank[:] = False  # It is fixed and near the cameras.
        shown[body.name] = blank, held
    kept = np.flatnonzero(draw.random(count) >= options.dropped)
    return replace(
        take, frame=take.frame[kept], time=take.time[kept],
        bodies=tuple(_degrade_body(body, *shown[body.name], kept) for body in take.bodies),
        markers=tuple(_degrade_marker(m, *shown[m.name.partition(":")[0]], kept) for m in take.markers),
    )  # fmt: skip


def _draw_spans(count: int, length: int, share: float, draw: np.random.Generator) -> np.ndarray:
    """Frames within random spans that cover about this share, shape (count,) [bool]."""
    out = np.zeros(count, bool)
    for begin in draw.integers(1, count, draw.poisson(share * count / length)):
        out[begin : begin + length] = True
    return out


def _show(values: np.ndarray, blank: np.ndarray, held: np.ndarray, kept: np.ndarray) -> np.ndarray:
    """Kept values, repeated where held, not a number where blank."""
    last = np.maximum.accumulate(np.where(held, 0, np.arange(len(held))))
    shown = values[last]
    shown[blank] = np.nan
    return shown[kept]


def _degrade_body(body: Body, blank: np.ndarray, held: np.ndarray, kept: np.ndarray) -> Body:
    values = (body.position, body.quaternion_wxyz, body.marker_error)
    position, quaternion, error = (_show(value, blank, held, kept) for value in values)
    return replace(body, position=position, quaternion_wxyz=quaternion, marker_error=error)


def _degrade_marker(marker: Marker, blank: np.ndarray, held: np.ndarray, kept: np.ndarray) -> Marker:
    return replace(marker, position=_show(marker.position, blank, held, kept))
