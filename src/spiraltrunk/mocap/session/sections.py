"""Sections of a recording by the names of its tracks, and their poses in a held shape."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import final

import numpy as np
from scipy.spatial.transform import Rotation

from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import TakeError
from spiraltrunk.mocap.protocol.protocol import Protocol
from spiraltrunk.mocap.recordings.take import Body, Marker, Take, format_names
from spiraltrunk.mocap.signal.registration import frame_from_markers
from spiraltrunk.mocap.signal.segmentation import compute_middle

FEWEST = 3
"""Least number of recorded sections [-]."""

_LEAST_SHARE = 0.2
"""Share of a still in which a section must be seen for its position to count [-] (ours)."""

_LEAST_FRAMES = 3

_NAME = re.compile(r"section[ _-]?0*([1-9][0-9]{0,2})", re.IGNORECASE)
_MARKER = re.compile(r"(.+?)(?:[:_ -]+(?:marker)?|marker)[ _-]?0*([1-3])", re.IGNORECASE)


@final
@dataclass(frozen=True, kw_only=True)
class SectionTracks:
    """Sections of one recording."""

    take: Take
    bodies: dict[int, Body]
    """Rigid bodies by section, from 1."""
    markers: dict[int, tuple[Marker, Marker, Marker]]
    """Markers 1 to 3 by section."""
    base: Body | None
    """Rigid body at the base."""
    points: np.ndarray
    """Centre of each section's markers, not a number where unseen or held, shape (n, n_section, 3) [m]."""


@final
@dataclass(frozen=True, kw_only=True)
class HeldShape:
    """Poses of sections and base in one still, in the recording's frame, y up."""

    begin: float
    """Time of its first frame [s]."""
    end: float
    points: np.ndarray
    """Centre of each section's markers, not a number where unseen, shape (n_section, 3) [m]."""
    rotation: np.ndarray
    """Axes of each section, not a number where unknown, shape (n_section, 3, 3) [-]."""
    base_point: np.ndarray
    """The base's origin, not a number where unseen, shape (3,) [m]."""
    base_rotation: np.ndarray
    """The base's axes, shape (3, 3) [-]."""


def find_sections(take: Take, design: TrunkDesign, protocol: Protocol) -> SectionTracks:
    """Sections of a recording by their names; too few, a duplicate and one beyond the design are refused."""
    named = {name: number for number, name in protocol.sections}
    within = f"1 to {design.n_section}, as the design {design.name!r} has"
    for name, number in named.items():
        if number > design.n_section:
            raise TakeError(f"the protocol's section {number} is {name[:40]!r}; allowed: {within}")

    def number_of(name: str) -> int | None:
        if named:
            return named.get(name)
        match = _NAME.fullmatch(name.strip())
        return int(match[1]) if match else None

    bodies = _find_bodies(take, number_of)
    markers = _find_markers(take, number_of)
    found = sorted({*bodies, *markers})
    if found and found[-1] > design.n_section:
        raise TakeError(f"section {found[-1]} recorded; allowed: {within}", file=take.source)
    if len(found) < FEWEST:
        listed = format_names([track.name for track in (*take.bodies, *take.markers)], 8)
        allowed = f"{FEWEST} or more rigid bodies section_01 ..., or markers section_01:Marker1 to 3, or [sections]"
        raise TakeError(f"{len(found)} sections found among {listed}; allowed: {allowed}", file=take.source)
    points = np.full((len(take.frame), design.n_section, 3), np.nan)
    for number in found:
        points[:, number - 1] = _track(bodies.get(number), markers.get(number))
    base = next((body for body in take.bodies if body.name == protocol.base), None)
    return SectionTracks(take=take, bodies=bodies, markers=markers, base=base, points=points)


def _find_bodies(take: Take, number_of: Callable[[str], int | None]) -> dict[int, Body]:
    bodies: dict[int, Body] = {}
    for body in take.bodies:
        number = number_of(body.name)
        if number is None:
            continue
        if number in bodies:
            reason = f"section {number} is there twice, as {bodies[number].name!r} and {body.name!r}; allowed: once"
            raise TakeError(reason, file=take.source)
        bodies[number] = body
    return bodies


def _find_markers(take: Take, number_of: Callable[[str], int | None]) -> dict[int, tuple[Marker, Marker, Marker]]:
    """Sections with all three markers; measured markers take precedence over solved ones."""
    found: dict[tuple[int, int], Marker] = {}
    for marker in take.markers:
        match = _MARKER.fullmatch(marker.name.strip())
        number = number_of(match[1]) if match else None
        if match is None or number is None:
            continue
        key = (number, int(match[2]))
        old = found.get(key)
        if old is not None and old.is_solved == marker.is_solved:
            reason = f"marker {key[1]} of section {number} is there twice; allowed: once"
            raise TakeError(reason, file=take.source)
        if old is None or old.is_solved:
            found[key] = marker
    whole = {number for number, _ in found if all((number, i) in found for i in (1, 2, 3))}
    return {number: (found[number, 1], found[number, 2], found[number, 3]) for number in whole}


def _track(body: Body | None, markers: tuple[Marker, ...] | None) -> np.ndarray:
    """Position of a section over time: its rigid body's, or the centre of its markers where the body is not seen."""
    center = np.mean([marker.seen for marker in markers], axis=0) if markers else np.full(3, np.nan)
    return center if body is None else np.where(body.is_seen[:, None], body.position, center)


def average_still(tracks: SectionTracks, frames: np.ndarray, orientation: str) -> HeldShape:
    """Poses of sections and base in a still: medians of seen positions, means of seen rotations."""
    least = max(_LEAST_FRAMES, round(_LEAST_SHARE * len(frames)))
    points = compute_middle(tracks.points[frames], least)
    rotation = np.full((len(points), 3, 3), np.nan)
    if orientation == "markers":
        for number, markers in tracks.markers.items():
            corners = np.stack([marker.seen[frames] for marker in markers], axis=1)
            rotation[number - 1] = frame_from_markers(compute_middle(corners, least))
    elif orientation == "body":
        for number, body in tracks.bodies.items():
            rotation[number - 1] = _average_axes(body, frames, least)
    rotation[np.isnan(points).any(axis=1)] = np.nan
    base_point, base_rotation = np.full(3, np.nan), np.full((3, 3), np.nan)
    if tracks.base is not None:
        base_point = compute_middle(tracks.base.seen[frames, None], least)[0]
        base_rotation = _average_axes(tracks.base, frames, least)
    begin, end = tracks.take.time[frames[[0, -1]]].tolist()
    return HeldShape(
        begin=begin, end=end, points=points, rotation=rotation, base_point=base_point, base_rotation=base_rotation
    )


def _average_axes(body: Body, frames: np.ndarray, least: int) -> np.ndarray:
    known = np.isfinite(body.quaternion_wxyz).all(axis=1) & body.is_seen
    xyzw = body.quaternion_wxyz[frames[known[frames]]][:, [1, 2, 3, 0]]
    return Rotation.from_quat(xyzw).mean().as_matrix() if len(xyzw) >= least else np.full((3, 3), np.nan)
