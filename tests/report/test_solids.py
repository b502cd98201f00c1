"""Shaded views: what is in front hides what is behind, and the parts of an exploded view stand apart."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
import trimesh
from matplotlib.backends.backend_agg import FigureCanvasAgg

from spiraltrunk.report.solids.pictures import (
    DrawnSolid,
    PlacedPart,
    build_camera,
    draw_solids,
    explode,
    write_pictures,
)
from spiraltrunk.report.solids.rasterise import rasterise
from spiraltrunk.report.style import build_figure

RED, BLUE = (1.0, 0.2, 0.2), (0.2, 0.2, 1.0)


def draw(solids: list[DrawnSolid], azimuth: float, elevation: float) -> np.ndarray:
    """Pixels of a figure that the axes fill, shape (400, 400, 3) [-]."""
    figure = build_figure(4.0, 4.0, "")
    figure.set_dpi(100)
    figure.set_layout_engine("none")
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    draw_solids(axes, solids, build_camera(azimuth, elevation), 400)
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    return np.asarray(canvas.buffer_rgba())[..., :3] / 255


def test_a_ball_is_a_disc_lit_from_above() -> None:
    picture = draw([DrawnSolid(name="ball", mesh=trimesh.creation.icosphere(4), color=RED)], 0.7, 0.4)
    is_drawn = picture[..., 1] < 0.9
    assert is_drawn.sum() == pytest.approx(math.pi * 200**2, rel=0.02)
    assert picture[is_drawn, 0].mean() > 2 * picture[is_drawn, 2].mean()
    upper, lower = np.array_split(np.arange(400), 2)
    assert picture[upper][is_drawn[upper], 0].mean() > picture[lower][is_drawn[lower], 0].mean()


def test_a_triangle_covers_its_area_once() -> None:
    triangle = np.array([[[0.0, 0.0, 3.0], [40.0, 0.0, 3.0], [0.0, 40.0, 3.0]]])
    depth, face = rasterise(triangle, 50, 50)
    assert abs((face == 0).sum() - 800) <= 40
    assert (depth[face == 0] == 3.0).all()
    assert (depth[face < 0] == -np.inf).all()
    assert (rasterise(triangle[:, ::-1], 50, 50)[1] == -1).all()  # It faces away.


@pytest.mark.parametrize("turn", [0.0, math.pi])
def test_what_is_nearer_hides_what_is_behind(turn: float) -> None:
    """A large plate behind a small one, of few and large triangles; seen from the other side it hides it."""
    plate = trimesh.creation.box((2, 40, 40))
    small = trimesh.creation.box((2, 10, 10)).apply_translation((4, 6, 6))
    solids = [DrawnSolid(name="", mesh=small, color=RED), DrawnSolid(name="", mesh=plate, color=BLUE)]
    picture = draw(solids, turn, 0.0)
    is_red = (picture[..., 0] > 2 * picture[..., 2]) & (picture[..., 0] > 0.4)
    expected = 400**2 / 16 if turn == 0.0 else 0.0
    assert is_red.sum() == pytest.approx(expected, rel=0.08)


def place(name: str, group: str, at: float, turn: float = 0.0) -> PlacedPart:
    ball = trimesh.creation.icosphere(2, radius=20.0)
    return PlacedPart(name=name, group=group, count=1, mesh=ball, at=(0.0, 0.0, at), turn=turn)


PARTS = [place("trunk_1", "trunk", 0.0), place("neck", "housing", -10.0), place("shell_01", "shells", 5.0),
         place("drum", "drums", -60.0), place("gripper", "gripper", 12.0, math.pi)]  # fmt: skip


def test_exploded_parts_do_not_overlap_along_the_axis() -> None:
    solids = explode(PARTS, 3)
    chain = [solid for solid in solids if solid.name in ("drums", "neck", "trunk_1", "gripper")]
    assert [solid.name for solid in chain] == ["drums", "neck", "trunk_1", "gripper"]
    for one, other in pairwise(chain):
        assert other.mesh.bounds[0, 2] > one.mesh.bounds[1, 2] + 10
    assert sum(solid.name == "" for solid in solids) == 2  # Two more drums.
    turned = PARTS[-1]
    np.testing.assert_allclose(turned.assembled().vertices[:, 2], 12.0 - turned.mesh.vertices[:, 2])


@pytest.mark.slow
def test_the_same_parts_give_the_same_pictures(tmp_path) -> None:
    for name in ("one", "other"):
        write_pictures(PARTS[:2], tmp_path / name, title="five balls", n_cable=3)
    names = ["exploded.png", "exploded.svg", "parts.png"]
    assert sorted(path.name for path in (tmp_path / "one").iterdir()) == names
    for name in names:
        assert (tmp_path / "one" / name).read_bytes() == (tmp_path / "other" / name).read_bytes()
