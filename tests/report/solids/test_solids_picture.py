"""Shaded views: what is in front hides what is behind, and a part fills its picture."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np

from spiraltrunk.report.solids.exploded import Placed, assembled, explode
from spiraltrunk.report.solids.rasterise import rasterise
from spiraltrunk.report.solids.solids_picture import PictureSolid, draw_view


def triangle(z: float) -> np.ndarray:
    return np.array([[[0.0, 0.0, z], [40.0, 0.0, z], [0.0, 40.0, z]]])


def test_a_triangle_covers_its_area_once():
    depth, face = rasterise(triangle(3.0), 50, 50)
    assert abs((face == 0).sum() - 800) <= 40
    assert (depth[face == 0] == 3.0).all()
    assert (depth[face < 0] == -np.inf).all()


def test_what_is_nearer_hides_what_is_behind():
    for order in ((1.0, 5.0), (5.0, 1.0)):
        depth, face = rasterise(np.concatenate([triangle(z) for z in order]), 50, 50)
        assert set(np.unique(face)) == {-1, order.index(5.0)}
        assert depth.max() == 5.0


def test_what_looks_away_is_not_seen():
    assert (rasterise(triangle(1.0)[:, ::-1], 50, 50)[1] == -1).all()


def ball(n: int = 40) -> np.ndarray:
    u, v = np.meshgrid(np.linspace(0, 2 * math.pi, n), np.linspace(0, math.pi, n), indexing="ij")
    p = np.stack([np.cos(u) * np.sin(v), np.sin(u) * np.sin(v), np.cos(v)], axis=-1)
    a, b, c, d = p[:-1, :-1], p[1:, :-1], p[1:, 1:], p[:-1, 1:]
    return np.concatenate([np.stack(t, axis=2).reshape(-1, 3, 3) for t in ((a, d, b), (b, d, c))])


def test_a_ball_is_a_disc():
    solid = PictureSolid(name="ball", corners=ball(), color=(1.0, 0.5, 0.2))
    picture, spots = draw_view([solid], 200, azimuth=0.7, elevation=0.4)
    opaque = picture[..., 3] > 0.5
    assert opaque.sum() == np.pi * 98**2 or abs(opaque.sum() / (np.pi * 98**2) - 1) < 0.02
    assert np.abs(spots[0] - np.array(opaque.shape[::-1]) / 2).max() < 4
    assert picture[opaque, 0].mean() > 2 * picture[opaque, 2].mean()
    # Light comes from above.
    rows = np.nonzero(opaque.any(axis=1))[0]
    upper, lower = np.array_split(rows, 2)
    assert picture[upper][opaque[upper], 0].mean() > picture[lower][opaque[lower], 0].mean()


def test_exploded_parts_do_not_overlap_along_the_axis():
    def placed(name, group, at, turn=0.0):
        return Placed(name=name, group=group, note="", count=1, corners=20 * ball(12), at=(0.0, 0.0, at), turn=turn)

    parts = [placed("trunk_1", "trunk", 0.0), placed("neck", "housing", -10.0), placed("shell_01", "shells", 5.0),
             placed("drum", "drums", -60.0), placed("gripper", "gripper", 12.0, math.pi)]  # fmt: skip
    solids = explode(parts, 3)
    chain = [solid for solid in solids if solid.name in ("drums", "neck", "trunk_1", "gripper")]
    assert [solid.name for solid in chain] == ["drums", "neck", "trunk_1", "gripper"]
    for one, other in pairwise(chain):
        assert other.corners[..., 2].min() > one.corners[..., 2].max() + 10
    assert sum(solid.name == "" for solid in solids) == 2  # Two more drums.
    assert np.allclose(assembled(parts[-1])[..., 2], 12.0 - parts[-1].corners[..., 2])
