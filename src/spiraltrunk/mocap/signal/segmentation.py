"""Segmentation of a recording into static shapes, and its gaps, which are never filled.

The speed at a frame is the root mean square, over the points, of the difference between the mean positions in the
window after it and in the window before it, over the window's length. Noise of sigma per frame gives a speed of about
sigma sqrt(6 / frames) / window: 1.4 mm/s for 0.5 mm at 100 Hz and 0.2 s.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import final

import numpy as np

from spiraltrunk.checks import check_number
from spiraltrunk.errors import TakeError
from spiraltrunk.field_docs import explain_fields

LONG = 0.1
"""Length from which a gap is noted [s]: at 0.2 m/s the trunk moves by 2 cm."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class StillSettings:
    """Criteria of a held shape."""

    speed: float = 5e-3
    """Speed below which the trunk is still [m/s] (ours: three times the noise)."""
    window: float = 0.2
    """Length of the averaging windows [s]."""
    hold: float = 0.6
    """Least time for which a shape is held, including the windows before and after [s]."""
    same: float = 1e-3
    """Root mean square distance below which consecutive stills are one shape [m]."""

    def __post_init__(self) -> None:
        check_number("still.speed_mm_s", 1e3 * self.speed, above=0.0, below=1e4)
        check_number("still.window_s", self.window, above=0.0, most=10.0)
        check_number("still.hold_s", self.hold, above=0.0, most=1e3)
        check_number("still.same_mm", 1e3 * self.same, least=0.0, below=1e3)


def compute_speed(points: np.ndarray, rate: float, window: float) -> np.ndarray:
    """Speed of the points, not a number where none is seen, shape (n,) [m/s]; arguments as of `find_stills`."""
    width = max(1, round(window * rate))
    seen = np.isfinite(points).all(axis=2)
    count = _sum_windows(seen[..., None].astype(float), width)
    mean = _sum_windows(np.where(seen[..., None], points, 0.0), width) / np.maximum(count, 1.0)
    both = (count[width:, :, 0] > 0) & (count[:-width, :, 0] > 0)
    step = ((mean[width:] - mean[:-width]) ** 2).sum(axis=2)
    number = both.sum(axis=1)
    motion = np.sqrt(np.where(both, step, 0.0).sum(axis=1) / np.maximum(number, 1))
    speed = np.full(len(points), np.nan)
    inner = np.where(number > 0, motion * rate / width, np.nan)
    speed[width : width + len(inner)] = inner
    if len(inner):  # Ends without a whole window take the nearest value.
        speed[:width], speed[width + len(inner) :] = inner[0], inner[-1]
    return speed


def _sum_windows(values: np.ndarray, width: int) -> np.ndarray:
    """Sums over all windows of ``width`` frames."""
    total = np.cumsum(np.concatenate([np.zeros((1, *values.shape[1:])), values]), axis=0)
    summed: np.ndarray = total[width:] - total[:-width]
    return summed


def find_stills(time: np.ndarray, points: np.ndarray, rate: float, settings: StillSettings) -> list[np.ndarray]:
    """Indices of the frames of each static shape, in order of time.

    Args:
        time: times of the frames, increasing, shape (n,) [s].
        points: positions of the sections, not a number where unseen, shape (n, k, 3) [m].
        rate: frames per second [Hz].
        settings: what counts as still.
    """
    is_still = compute_speed(points, rate, settings.window) < settings.speed
    stills: list[np.ndarray] = []
    for frames in _find_spans(is_still, time, rate):
        if _is_short(time[frames], rate, settings):
            continue
        if stills and _distance(points[stills[-1]], points[frames]) < settings.same:
            stills[-1] = np.concatenate([stills[-1], frames])
        else:
            stills.append(frames)
    return stills


def find_timed(
    time: np.ndarray, points: np.ndarray, rate: float, settings: StillSettings, schedule: tuple[float, float, int]
) -> list[np.ndarray]:
    """The longest still of each period, as `find_stills`.

    ``schedule`` is the start of the first period [s], the length of a period [s] and the number of periods.

    Raises:
        TakeError: for a period without a still long enough.
    """
    begin, period, count = schedule
    is_still = compute_speed(points, rate, settings.window) < settings.speed
    stills = []
    for i in range(count):
        from_, to = begin + i * period, begin + (i + 1) * period
        spans = _find_spans(is_still & (time >= from_) & (time < to), time, rate)
        if not spans or _is_short(time[longest := max(spans, key=len)], rate, settings):
            reason = f"from {from_:.2f} to {to:.2f} s nothing is still for {settings.hold:g} s"
            raise TakeError(f"{reason}; allowed: a still in each period: see begin_s, period_s, [still]")
        stills.append(longest)
    return stills


def describe_slowest(time: np.ndarray, points: np.ndarray, rate: float, settings: StillSettings) -> str:
    """Length of a recording without stills, and the smallest maximum speed of any stretch as long as a still."""
    what = f"no static shape found in {len(time)} frames, {len(time) / rate:.2f} s"
    width = max(0, math.ceil((settings.hold - 2 * settings.window) * rate - 0.5)) + 1
    if len(time) >= width:
        speed = compute_speed(points, rate, settings.window)
        worst = np.lib.stride_tricks.sliding_window_view(speed, width).max(axis=1)
        known = worst[np.isfinite(worst) & (time[width - 1 :] - time[: len(worst)] < (width - 0.5) / rate)]
        if len(known):
            most = f"above {1e3 * settings.speed:g} mm/s, so that nothing is still (or are lengths in another unit?)"
            return f"{what}: the slowest stretch of {settings.hold:g} s moves at {1e3 * known.min():.3g} mm/s, {most}"
    return f"{what}, too short or too full of gaps for one of {settings.hold:g} s"


def _is_short(time: np.ndarray, rate: float, settings: StillSettings) -> bool:
    """Whether a still, with the windows before and after, is shorter than a hold."""
    return bool(time[-1] - time[0] + 2 * settings.window < settings.hold - 0.5 / rate)


def _find_spans(is_still: np.ndarray, time: np.ndarray, rate: float) -> list[np.ndarray]:
    """Runs of still frames without missing frames between them [-]."""
    frames = np.flatnonzero(is_still)
    is_break = (np.diff(frames) > 1) | (np.diff(time[frames]) > 1.5 / rate)
    return [run for run in np.split(frames, np.flatnonzero(is_break) + 1) if len(run)]


def _distance(one: np.ndarray, other: np.ndarray) -> float:
    """Root mean square distance of two shapes' median frames over points seen in both; infinite without any."""
    step = ((compute_middle(one) - compute_middle(other)) ** 2).sum(axis=1)
    seen = np.isfinite(step)
    return float(np.sqrt(step[seen].mean())) if seen.any() else np.inf


def compute_middle(points: np.ndarray, least: int = 1) -> np.ndarray:
    """Median over the frames that saw a point, not a number below ``least`` of them: (n, k, 3) to (k, 3) [m]."""
    seen = np.isfinite(points).all(axis=2)
    middle = np.full(points.shape[1:], np.nan)
    for k in np.flatnonzero(seen.sum(axis=0) >= least):
        middle[k] = np.median(points[seen[:, k], k], axis=0)
    return middle


def find_gaps(is_seen: np.ndarray, time: np.ndarray, longest: float = LONG) -> list[tuple[float, float]]:
    """Start and end of each gap longer than ``longest``, from the last frame seen to the next [s].

    A gap at an end of the recording begins or ends with it.
    """
    marks = np.concatenate([time[:1], time[is_seen], time[-1:]])
    long = np.flatnonzero(np.diff(marks) > longest)
    return [(float(marks[i]), float(marks[i + 1])) for i in long]


def summarise_gaps(seen: Mapping[str, np.ndarray], time: np.ndarray) -> list[str]:
    """One note on the gaps longer than `LONG` of all tracks, by the frames in which each was seen; else none."""
    gaps = [(end - begin, name, begin, end) for name in seen for begin, end in find_gaps(seen[name], time)]
    if not gaps:
        return []
    _, name, begin, end = max(gaps)
    sections = len({gap[1] for gap in gaps})
    many, few = ("gap" if len(gaps) == 1 else "gaps"), ("section" if sections == 1 else "sections")
    what = f"{len(gaps)} {many} of more than {1e3 * LONG:g} ms in {sections} {few}, none filled"
    return [f"{what}; the longest in {name} from {begin:.2f} to {end:.2f} s"]
