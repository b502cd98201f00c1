"""Statistics of features, by which learning scales its inputs: of an episode, and of all."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

QUANTILES = {"q01": 0.01, "q10": 0.10, "q50": 0.50, "q90": 0.90, "q99": 0.99}
"""Quantiles by their names [-]."""

PICTURES = 100
"""Most pictures of an episode that its statistics are of (ours)."""

Statistics = dict[str, np.ndarray]
"""Statistics of a feature by their names."""


def compute_statistics(values: np.ndarray) -> Statistics:
    """Statistics of n values of a feature, shape (n, ...), each of shape (...), at least 1-D; count of shape (1,)."""
    values = np.asarray(values, float).reshape(len(values), -1)
    spread = {"min": values.min(0), "max": values.max(0), "mean": values.mean(0), "std": values.std(0)}
    quantiles = dict(zip(QUANTILES, np.quantile(values, list(QUANTILES.values()), axis=0), strict=True))
    return {**spread, "count": np.array([len(values)]), **quantiles}


def compute_picture_statistics(pictures: Sequence[np.ndarray]) -> Statistics:
    """Statistics of each colour over pictures, each of shape (height, width, 3), 0 to 255: of shape (3, 1, 1), 0 to 1.

    ``count`` is the number of pictures.
    """
    shown = np.linspace(0, len(pictures) - 1, min(len(pictures), PICTURES)).round().astype(int)
    pixels = np.stack([pictures[i] for i in shown]).reshape(-1, 3) / 255.0
    found = {key: value.reshape(3, 1, 1) for key, value in compute_statistics(pixels).items() if key != "count"}
    return found | {"count": np.array([len(shown)])}


class Total:
    """Statistics over all episodes, gathered one after another.

    Mean and variance are exact: the variances within episodes plus that of their means, weighted by their counts.
    Quantiles are the weighted means of the episodes' quantiles, as LeRobot's own.
    """

    def __init__(self) -> None:
        self._sums: dict[str, dict[str, np.ndarray]] = {}

    def add(self, statistics: dict[str, Statistics]) -> None:
        """Take in an episode's statistics by feature."""
        for key, found in statistics.items():
            n, mean = float(found["count"][0]), found["mean"]
            own = {"n": found["count"], "mean": n * mean, "square": n * (found["std"] ** 2 + mean**2)}
            own |= {name: n * found[name] for name in QUANTILES}
            low, high = found["min"], found["max"]
            if key in self._sums:
                before = self._sums[key]
                own = {name: before[name] + value for name, value in own.items()}
                low, high = np.minimum(before["min"], low), np.maximum(before["max"], high)
            self._sums[key] = own | {"min": low, "max": high}

    def compute(self) -> dict[str, Statistics]:
        """The statistics by feature."""
        return {key: _average(sums) for key, sums in self._sums.items()}


def _average(sums: dict[str, np.ndarray]) -> Statistics:
    n = float(sums["n"][0])
    mean = sums["mean"] / n
    std = np.sqrt(np.maximum(sums["square"] / n - mean**2, 0.0))
    found = {"min": sums["min"], "max": sums["max"], "mean": mean, "std": std, "count": sums["n"]}
    return found | {name: sums[name] / n for name in QUANTILES}
