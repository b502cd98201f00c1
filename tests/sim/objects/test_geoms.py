"""The support function of a geom is the coordinate of its farthest point."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from spiraltrunk.sim.objects.geoms import Geom

RANDOM = np.random.default_rng(0)
UNIT = RANDOM.normal(size=(50_000, 3))
UNIT /= np.linalg.norm(UNIT, axis=1)[:, None]
CORNERS = np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1])).reshape(3, -1).T
CIRCLE = np.linspace(0.0, 2 * np.pi, 2000)
RIM = np.array([(np.cos(angle), np.sin(angle), end) for angle in CIRCLE for end in (-1, 1)])

SURFACES = {
    "sphere": ((0.04, 0.0, 0.0), 0.04 * UNIT),
    "capsule": ((0.02, 0.05, 0.0), 0.02 * UNIT + 0.05 * np.sign(UNIT) * [0.0, 0.0, 1.0]),
    "ellipsoid": ((0.02, 0.05, 0.09), UNIT * [0.02, 0.05, 0.09]),
    "cylinder": ((0.03, 0.05, 0.0), RIM * [0.03, 0.03, 0.05]),
    "box": ((0.02, 0.05, 0.09), CORNERS * [0.02, 0.05, 0.09]),
    "mesh": ((0.0, 0.0, 0.0), 0.1 * RANDOM.normal(size=(20, 3))),
}
"""MuJoCo's size of each form, and points that are its surface or whose hull it is."""


@pytest.mark.parametrize("form", SURFACES)
def test_reach_is_that_of_the_farthest_point(form):
    size, points = SURFACES[form]
    turn, place = Rotation.from_rotvec([0.3, -0.8, 0.5]).as_matrix(), np.array([0.01, 0.02, -0.03])
    geom = Geom(form=form, size=size, position=place, rotation=turn, vertices=points if form == "mesh" else None)
    for direction in (*UNIT[:20], *np.eye(3), *turn.T):
        farthest = float(((points @ turn.T + place) @ direction).max())
        assert farthest - 1e-12 <= geom.reach(direction) <= farthest + 1e-4
