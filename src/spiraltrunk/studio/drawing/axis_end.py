"""Ends of axes and scales that stay while their values change a little."""

from __future__ import annotations

_PARTS = (1.0, 2.0, 5.0)


def round_up(value: float, least: float) -> float:
    """Smallest of 1, 2 or 5 times a power of ten that is at least a value, and at least ``least``, itself one."""
    power = 1e-6
    while True:
        for part in _PARTS:
            if part * power >= max(value, least) * (1 - 1e-9):
                return part * power
        power *= 10.0
