"""A series holds arrays that fit one another, or says which does not."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from spiraltrunk.errors import ShapeError
from spiraltrunk.report import Series

BAD = {
    "cable_pull": (np.zeros((119, 3)), r"cable_pull has shape \(119, 3\)"),
    "cable_tension": (np.zeros((120, 2)), r"cable_tension has shape \(120, 2\); allowed: cable_pull's, \(120, 3\)"),
    "joint_bend": (np.zeros(120), r"joint_bend has shape \(120,\)"),
    "object_height": (np.zeros((120, 3)), r"object_height has shape \(120, 3\); allowed: \(120,\)"),
    "grip_force": (np.full(120, np.nan), "grip_force holds what is not finite"),
    "string_tension": (["much"] * 120, "string_tension is not an array of numbers"),
    "time": (np.linspace(1.0, 0.0, 120), "each later than the one before"),
    "section_length": (np.ones(17), r"section_length has shape \(17,\); allowed: \(18,\), one more than there are"),
    "joint_limit": (0.0, "joint_limit is 0.0"),
    "lift": ((0.9, np.inf), r"lift is \(0.9, inf\)"),
    "phase_spans": ((("reach", 2.0, 1.0),), "phase reach spans 2.0 to 1.0 s"),
}


@pytest.mark.parametrize("name", BAD)
def test_misfit_is_named(build: Callable[..., Series], name: str) -> None:
    value, message = BAD[name]
    with pytest.raises(ShapeError, match=message):
        build(**{name: value})


def test_sections_have_a_length(build: Callable[..., Series]) -> None:
    with pytest.raises(ShapeError, match=r"section_length is 0 m at least; allowed: > 0 m"):
        build(section_length=np.arange(18.0))


@pytest.mark.parametrize("n", [0, 1])
def test_one_instant_is_no_series(parts: dict[str, Any], n: int) -> None:
    short = {name: value[:n] if isinstance(value, np.ndarray) else value for name, value in parts.items()}
    with pytest.raises(ShapeError, match="time has"):
        Series(**short)


def test_time_that_is_a_number_is_refused(build: Callable[..., Series]) -> None:
    with pytest.raises(ShapeError, match="time has shape"):
        build(time=3.0)


def test_series_keeps_its_own_copy(parts: dict[str, Any]) -> None:
    series = Series(**parts)
    parts["time"][0] = -99.0
    assert series.time[0] == 0.0
    with pytest.raises(ValueError, match="read-only"):
        series.time[0] = 1.0
    assert (series.n_cable, series.n_joint) == (3, 17)
