"""Gaps of a recording. They are never filled: what was not seen stays not a number."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

LONG = 0.1
"""Length from which a gap is noted [s]: at 0.2 m/s the trunk moves by 2 cm."""


def find_gaps(is_seen: np.ndarray, time: np.ndarray, longest: float = LONG) -> list[tuple[float, float]]:
    """Begin and end of each gap longer than ``longest``, from the last frame seen to the next [s].

    A gap at an end of the recording begins or ends with it.

    Args:
        is_seen: frames in which something was seen, shape (n,) [bool].
        time: times of the frames, increasing, shape (n,) [s].
        longest: length up to which a gap is left out [s].
    """
    marks = np.concatenate([time[:1], time[is_seen], time[-1:]])
    long = np.flatnonzero(np.diff(marks) > longest)
    return [(float(marks[i]), float(marks[i + 1])) for i in long]


def summarise_gaps(seen: Mapping[str, np.ndarray], time: np.ndarray) -> list[str]:
    """One note on the gaps longer than `LONG` of all tracks, none where there are none.

    Args:
        seen: frames in which each track was seen, by name, shape (n,) [bool].
        time: times of the frames, shape (n,) [s].
    """
    found = {name: gaps for name, is_seen in seen.items() if (gaps := find_gaps(is_seen, time))}
    if not found:
        return []
    count = sum(map(len, found.values()))
    name, (begin, end) = max(
        ((name, gap) for name, gaps in found.items() for gap in gaps), key=lambda item: item[1][1] - item[1][0]
    )
    what = f"{count} gaps of more than {1e3 * LONG:g} ms in {len(found)} sections, none filled"
    return [f"{what}; the longest in {name} from {begin:.2f} to {end:.2f} s"]
