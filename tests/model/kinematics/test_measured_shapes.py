"""Measured shapes that do not fit each other are refused."""

from __future__ import annotations

import numpy as np
import pytest

from spiraltrunk.errors import ModelError
from spiraltrunk.model.kinematics.measured_shapes import MeasuredShapes


def parts() -> dict:
    return {
        "kind": ("rest", "bend-dorsal", "bend-dorsal"), "take": ("a", "b", "b"), "theta_0": np.zeros(3),
        "pull": np.full((3, 3), np.nan), "follows": np.array([-1, -1, 1]), "marker_offset": np.linspace(0.05, 0.01, 4),
        "points": np.full((3, 4, 3), np.nan), "rotation": np.full((3, 4, 3, 3), np.nan),
    }  # fmt: skip


def test_what_was_not_seen_may_be_missing() -> None:
    assert MeasuredShapes(**parts()).follows.tolist() == [-1, -1, 1]


@pytest.mark.parametrize(
    ("name", "value", "told"),
    [
        ("kind", ("rest", "kick", "rest"), "kind is 'kick'; allowed: rest"),
        ("take", ("a",), "take has 1 names for 3 shapes"),
        ("theta_0", np.zeros(2), r"theta_0 has shape \(2,\); allowed: \(3,\)"),
        ("theta_0", np.array([0.0, np.nan, 0.0]), "theta_0 is nan; allowed: a finite number"),
        ("marker_offset", np.array([0.0, np.inf, 0.0, 0.0]), "offset is inf; allowed: a finite number"),
        ("pull", np.zeros(3), "pull has shape"),
        ("pull", np.full((3, 3), np.inf), "pull is infinite"),
        ("points", np.zeros((3, 5, 3)), "points has shape"),
        ("points", np.full((3, 4, 3), -np.inf), "points is infinite"),
        ("rotation", np.zeros((3, 4, 3)), "rotation has shape"),
        ("follows", np.array([-1, 1, 1]), "shape 1 follows 1; allowed: -1, or a shape before it"),
        ("follows", np.array([-1, -2, 1]), "shape 1 follows -2"),
        ("follows", np.array([-1, -1, 0.5]), "shape 2 follows 0.5"),
    ],
)
def test_what_does_not_fit_is_refused(name: str, value: object, told: str) -> None:
    with pytest.raises(ModelError, match=told):
        MeasuredShapes(**{**parts(), name: value})
