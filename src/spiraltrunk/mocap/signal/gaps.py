"""Where a recording saw nothing. Nothing is ever filled in: a shape that was not seen stays not a number."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

LONG = 0.1
"""Length from which on a gap is told [s]: a trunk that moves at 0.2 m/s is then 2 cm further."""


def find_gaps(is_seen: np.ndarray, time: np.ndarray, longest: float = LONG) -> list[tuple[float, float]]:
    """Begin and end of each gap that is longer than ``longest``, from the last frame seen to the next [s].

    A gap at an end of the recording begins or ends with it.

    Args:
        is_seen: frames in which something was seen, shape (n,) [bool].
        time: times of the frames, increasing, shape (n,) [s].
        longest: length up to which a gap is not told [s].
    """
    if not len(time):
        return []
    known = time[is_seen]
    marks = np.concatenate([time[:1], known, time[-1:]])
    if not len(known):
        return [(float(time[0]), float(time[-1]))] if time[-1] - time[0] > longest else []
    long = np.flatnonzero(np.diff(marks) > longest)
    return [(float(marks[i]), float(marks[i + 1])) for i in long]


def tell_gaps(seen: Mapping[str, np.ndarray], time: np.ndarray) -> list[str]:
    """One note on the gaps longer than `LONG` of all that was tracked, none where there are none.

    Args:
        seen: frames in which each was seen, by its name, shape (n,) [bool].
        time: times of the frames, shape (n,) [s].
    """
    found = {name: gaps for name, is_seen in seen.items() if (gaps := find_gaps(is_seen, time))}
    if not found:
        return []
    count = sum(map(len, found.values()))
    name, (begin, end) = max(
        ((name, gap) for name, gaps in found.items() for gap in gaps), key=lambda item: item[1][1] - item[1][0]
    )
    told = f"{count} gaps of more than {1e3 * LONG:g} ms in {len(found)} sections, none filled"
    return [f"{told}; the longest in {name} from {begin:.2f} to {end:.2f} s"]
