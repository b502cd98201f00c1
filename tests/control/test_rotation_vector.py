"""Rotation vectors and matrices: against SciPy, by the round trip, and at angles where quotients become series."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from spiraltrunk.control.encoding.rotation_vector import measure_turn, rotate_by

RANDOM = np.random.default_rng(4)
DIRECTIONS = [np.eye(3)[i] for i in range(3)] + [v / np.linalg.norm(v) for v in RANDOM.normal(size=(8, 3))]


@pytest.mark.parametrize("angle", [0.0, 1e-12, 9.99e-4, 1.001e-3, 0.4, 2.0, np.pi - 1e-6])
def test_they_are_those_of_scipy_and_each_others_inverse(angle):
    for direction in DIRECTIONS:
        turn = angle * direction
        matrix = rotate_by(turn.tolist())
        np.testing.assert_allclose(matrix, Rotation.from_rotvec(turn).as_matrix(), rtol=0, atol=1e-15)
        np.testing.assert_allclose(measure_turn(matrix), turn, rtol=0, atol=1e-9)
        np.testing.assert_allclose(measure_turn(matrix), Rotation.from_matrix(matrix).as_rotvec(), rtol=0, atol=1e-14)


def test_an_angle_beyond_half_a_turn_is_measured_the_short_way_round():
    np.testing.assert_allclose(measure_turn(rotate_by([0.0, 0.0, 4.0])), [0.0, 0.0, 4.0 - 2 * np.pi], atol=1e-15)
