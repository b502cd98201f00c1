"""Where in a recording the trunk is still: its static shapes, found by themselves.

At each instant the mean positions over a window after it are compared with those over a window before it; the root mean
square over the points, over the window, is the speed. Noise of sigma per frame leaves a speed of about
sigma sqrt(6 / frames) / window: 1.4 mm/s for 0.5 mm at 100 Hz and 0.2 s.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import final

import numpy as np

from spiraltrunk.checks import check_number
from spiraltrunk.errors import TakeError


@final
@dataclass(frozen=True, kw_only=True)
class StillSettings:
    """What counts as a held shape."""

    speed: float = 5e-3
    """Speed below which the trunk is still, root mean square over its points [m/s] (ours: three times the noise)."""
    window: float = 0.2
    """Time over which motion is seen [s]."""
    hold: float = 0.6
    """Least time for which a shape is held [s], the windows before and after what is still counted in."""
    same: float = 1e-3
    """Distance below which two stills after each other are one shape, root mean square over points [m]."""

    def __post_init__(self) -> None:
        check_number("still.speed_mm_s", 1e3 * self.speed, above=0.0, below=1e4)
        check_number("still.window_s", self.window, above=0.0, most=10.0)
        check_number("still.hold_s", self.hold, above=0.0, most=1e3)
        check_number("still.same_mm", 1e3 * self.same, least=0.0, below=1e3)


@final
@dataclass(frozen=True, kw_only=True)
class Still:
    """One static shape."""

    frames: np.ndarray
    """Indices of its frames, increasing, shape (k,) [-]."""
    begin: float
    """Time of its first frame [s]."""
    end: float
    """Time of its last frame [s]."""


def compute_speed(points: np.ndarray, rate: float, window: float) -> np.ndarray:
    """How fast the points move, not a number where too few are seen, shape (n,) [m/s].

    Args:
        points: positions over time, not a number where unseen, shape (n, k, 3) [m].
        rate: frames per second [Hz].
        window: time over which positions are averaged [s].
    """
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
    if len(inner):  # The ends, where a window does not fit, are taken as what is next to them.
        speed[:width], speed[width + len(inner) :] = inner[0], inner[-1]
    return speed


def _sum_windows(values: np.ndarray, width: int) -> np.ndarray:
    """Sums over all windows of ``width`` frames that fit, shape (n - width + 1, ...)."""
    if len(values) < width:
        return values[:0]
    total = np.cumsum(np.concatenate([np.zeros((1, *values.shape[1:])), values]), axis=0)
    summed: np.ndarray = total[width:] - total[:-width]
    return summed


def find_stills(time: np.ndarray, points: np.ndarray, rate: float, settings: StillSettings) -> list[Still]:
    """Static shapes of a recording, in order of time.

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
    return [Still(frames=frames, begin=float(time[frames[0]]), end=float(time[frames[-1]])) for frames in stills]


def find_timed(
    time: np.ndarray, points: np.ndarray, rate: float, settings: StillSettings, schedule: tuple[float, float, int]
) -> list[Still]:
    """Static shapes where steps are timed: in each period, what is still for longest.

    Args:
        time: times of the frames, increasing, shape (n,) [s].
        points: positions of the sections, shape (n, k, 3) [m].
        rate: frames per second [Hz].
        settings: what counts as still.
        schedule: begin of the first period [s], its length [s], and how many there are.

    Raises:
        TakeError: for a period without a still long enough.
    """
    begin, period, count = schedule
    is_still = compute_speed(points, rate, settings.window) < settings.speed
    stills = []
    for i in range(count):
        from_, to = begin + i * period, begin + (i + 1) * period
        within = is_still & (time >= from_) & (time < to)
        frames = max(_find_spans(within, time, rate), key=len, default=np.empty(0, int))
        if not len(frames) or _is_short(time[frames], rate, settings):
            told = f"from {from_:.2f} to {to:.2f} s nothing is still for {settings.hold:g} s"
            raise TakeError(f"{told}; allowed: a still in each period: see begin_s, period_s, [still]")
        stills.append(Still(frames=frames, begin=float(time[frames[0]]), end=float(time[frames[-1]])))
    return stills


def compute_calmest(time: np.ndarray, points: np.ndarray, rate: float, settings: StillSettings) -> float:
    """Least speed that a stretch as long as a still does not pass, not a number where there is none [m/s].

    Args:
        time: times of the frames, increasing, shape (n,) [s].
        points: positions of the sections, not a number where unseen, shape (n, k, 3) [m].
        rate: frames per second [Hz].
        settings: what counts as still.
    """
    speed = compute_speed(points, rate, settings.window)
    width = max(0, math.ceil((settings.hold - 2 * settings.window) * rate - 0.5)) + 1
    if len(speed) < width:
        return math.nan
    worst = np.lib.stride_tricks.sliding_window_view(speed, width).max(axis=1)
    known = worst[np.isfinite(worst) & (time[width - 1 :] - time[: len(worst)] < (width - 0.5) / rate)]
    return float(known.min()) if len(known) else math.nan


def tell_calmest(time: np.ndarray, points: np.ndarray, rate: float, settings: StillSettings) -> str:
    """What a recording without stills holds: how long it is and how calm it gets; arguments as `compute_calmest`'s."""
    told = f"no static shape found in {len(time)} frames, {len(time) / rate:.2f} s"
    speed = compute_calmest(time, points, rate, settings)
    if math.isnan(speed):
        return f"{told}, too short or too full of gaps for one of {settings.hold:g} s"
    most = f"above {1e3 * settings.speed:g} mm/s, so that nothing is still (or are lengths in another unit?)"
    return f"{told}: the slowest stretch of {settings.hold:g} s moves at {1e3 * speed:.3g} mm/s, {most}"


def _is_short(time: np.ndarray, rate: float, settings: StillSettings) -> bool:
    """Whether what is still, with the windows that showed it, lasts less than a hold."""
    return bool(time[-1] - time[0] + 2 * settings.window < settings.hold - 0.5 / rate)


def _find_spans(is_still: np.ndarray, time: np.ndarray, rate: float) -> list[np.ndarray]:
    """Runs of frames that are still, without missing frames between them [-]."""
    after_gap = np.concatenate([[False], np.diff(time) > 1.5 / rate])
    padded = np.concatenate([[False], is_still, [False]])
    starts = np.flatnonzero(padded[1:-1] & (~padded[:-2] | after_gap))
    ends = np.flatnonzero(padded[1:-1] & (~padded[2:] | np.concatenate([after_gap[1:], [False]])))
    return [np.arange(first, last + 1) for first, last in zip(starts, ends, strict=True)]


def _distance(one: np.ndarray, other: np.ndarray) -> float:
    """Distance of two shapes by the median of their frames, over points seen in both; infinite where there is none."""
    a, b = compute_middle(one), compute_middle(other)
    step = ((a - b) ** 2).sum(axis=1)
    seen = np.isfinite(step)
    return float(np.sqrt(step[seen].mean())) if seen.any() else np.inf


def compute_middle(points: np.ndarray, least: int = 1) -> np.ndarray:
    """Median over frames of what is seen in at least ``least`` of them, else not a number, shape (k, ...) [m].

    Args:
        points: shape (n, k, ...) [m].
        least: frames that are asked for.
    """
    axes = tuple(range(2, points.ndim))
    seen = np.isfinite(points).all(axis=axes) if axes else np.isfinite(points)
    middle = np.full(points.shape[1:], np.nan)
    for k in np.flatnonzero(seen.sum(axis=0) >= max(1, least)):
        middle[k] = np.median(points[seen[:, k], k], axis=0)
    return middle
