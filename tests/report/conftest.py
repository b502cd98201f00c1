"""A run as the simulator would record it, written down in closed form."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from spiraltrunk.report import Series

N, N_JOINT = 120, 17


def ramp(time: np.ndarray, begin: float, end: float) -> np.ndarray:
    share = np.clip((time - begin) / (end - begin), 0.0, 1.0)
    return share**2 * (3.0 - 2.0 * share)


@pytest.fixture
def parts() -> dict[str, Any]:
    time = np.linspace(0.0, 12.0, N)
    grasp = ramp(time, 2.0, 5.0) - ramp(time, 10.0, 11.5)
    delay = np.linspace(1.5, 0.0, N_JOINT)
    bend = 0.5 * np.stack([ramp(time, 2.0 + d, 3.0 + d) for d in delay], axis=1)
    return {
        "time": time,
        "phase_spans": (
            ("reach", 0.0, 1.9),
            ("prehension", 2.0, 4.9),
            ("transport", 5.0, 9.9),
            ("release", 10.0, 12.0),
        ),
        "cable_pull": np.outer(grasp, [-0.09, 0.06, 0.058]),
        "cable_tension": 1.0 + np.outer(grasp, [0.0, 18.0, 17.0]),
        "joint_bend": bend,
        "joint_limit": np.pi / 6,
        "section_length": 0.05 * 0.92 ** np.arange(N_JOINT + 1),
        "object_height": 0.9 + 0.2 * (ramp(time, 5.0, 6.0) - ramp(time, 8.0, 9.5)),
        "lift": (0.9, 1.1),
        "grip_force": 22.0 * grasp,
        "string_tension": 2.0 * (1.0 - ramp(time, 5.0, 5.5)),
        "title": "paper, wrap_vertical, $40 and 5$",
    }


@pytest.fixture
def build(parts: dict[str, Any]) -> Callable[..., Series]:
    return lambda **changes: Series(**{**parts, **changes})


@pytest.fixture
def series(build: Callable[..., Series]) -> Series:
    return build()
