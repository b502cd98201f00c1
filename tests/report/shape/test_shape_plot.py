"""The picture of a shape shows sections, cables and shut joints where the model has them."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg

from spiraltrunk.design import presets
from spiraltrunk.design.presets import PAPER
from spiraltrunk.model import reference
from spiraltrunk.model.kinematics.shape import Shape
from spiraltrunk.report.shape.shape_plot import _size_dots, build_shape_figure, build_solids
from spiraltrunk.report.style import write_figure

SHAPES = {
    "rest": (0.0, lambda theta: reference.rest(PAPER, theta)),
    "dorsal": (math.pi / 2, lambda theta: reference.bend_dorsal(PAPER, 0.06, theta)),
    "ventral": (0.75 * math.pi, lambda theta: reference.bend_ventral(PAPER, 0.1, theta)),
    "twist": (math.pi / 4, lambda theta: reference.twist(PAPER, 0.06, 0.03, theta)),
    "full": (math.pi / 2, lambda theta: reference.bend_dorsal(PAPER, 0.13, theta)),
}


@pytest.fixture(
    params=[name if name in {"twist", "full"} else pytest.param(name, marks=pytest.mark.slow) for name in SHAPES]
)
def posed(request: pytest.FixtureRequest) -> tuple[Shape, float]:
    theta_0, law = SHAPES[request.param]
    return law(theta_0), theta_0


def test_sections_and_gaps_are_the_models(posed: tuple[Shape, float]) -> None:
    shape, theta_0 = posed
    solids = build_solids(PAPER, shape, theta_0)
    ends = solids.outline[:, 3].mean(axis=1)
    np.testing.assert_allclose(ends, 1e3 * shape.points, atol=1e-6)
    np.testing.assert_allclose(solids.center, 1e3 * shape.points[:-1], atol=1e-6)
    # The authors' rounded gaps of a shape are not those of its geometry.
    gap = np.linalg.norm(np.diff(solids.gaps, axis=2)[:, :, 0], axis=-1).T
    np.testing.assert_allclose(gap, 1e3 * shape.gap, atol=0.1)
    width = np.linalg.norm(solids.outline[:, 1] - solids.outline[:, 1].mean(axis=1, keepdims=True), axis=-1)
    np.testing.assert_allclose(width, 1e3 * np.repeat(PAPER.section_radius[:, None], width.shape[1], axis=1))


def test_faces_that_meet_do_not_pass_each_other() -> None:
    """At full curl the rims on the shut side touch, in the plane of bending."""
    solids = build_solids(PAPER, reference.bend_dorsal(PAPER, 0.13, math.pi / 2), math.pi / 2)
    touching = np.linalg.norm(solids.outline[:-1, 2, 0] - solids.outline[1:, 1, 0], axis=-1)
    assert touching.max() < 0.1
    assert solids.is_shut.all()


def test_nothing_is_cut_off(posed: tuple[Shape, float]) -> None:
    figure = build_shape_figure(PAPER, *posed, title="paper, reference, at rest")
    FigureCanvasAgg(figure).draw()
    space, side, end = figure.axes
    solids = build_solids(PAPER, *posed)
    for axes, right in ((side, 0), (end, 2)):
        for values, (low, high) in (
            (solids.outline[..., right], axes.get_xlim()),
            (solids.outline[..., 1], axes.get_ylim()),
        ):
            assert low < values.min() < values.max() < high
        across, up = np.ptp(axes.get_xlim()), np.ptp(axes.get_ylim())
        box = axes.get_window_extent()
        assert box.width / across == pytest.approx(box.height / up, rel=1e-3)
        assert "mm" in axes.get_xlabel()
    edges = [abs(np.ptp(getattr(space, f"get_{name}lim")())) for name in "xyz"]
    assert edges == pytest.approx([edges[0]] * 3)
    labels = {text.get_text() for text in figure.legends[0].get_texts()}
    assert {"section", "cable 1", "cable 3", "base axis"} <= labels
    count = int(solids.is_shut.sum())
    assert (f"shut joint ({count})" in labels) == (count > 0)
    drawn, size = figure.get_tightbbox(), figure.get_size_inches()
    assert (drawn.min >= -1e-6).all()
    assert (drawn.max <= size + 1e-6).all()


def test_other_designs_are_drawn(tmp_path: Path) -> None:
    design = presets.get("spirob-15")
    shape = reference.bend_dorsal(design, 0.02, 0.0)
    figure = build_shape_figure(design, shape, 0.0)
    assert write_figure(figure, tmp_path / "shape.png").stat().st_size > 10_000


def test_of_cables_behind_one_another_both_are_seen() -> None:
    """From the side cables 2 and 3 of the bent trunk lie on one line, from the end none does."""
    theta_0 = 1.0
    _, side, end = build_shape_figure(PAPER, reference.bend_dorsal(PAPER, 0.05, theta_0), theta_0).axes
    styles = [[line.get_linestyle() for line in axes.lines[:3]] for axes in (side, end)]
    assert styles == [["-", "-", "--"], ["-", "-", "-"]]


def test_dots_of_shut_joints_shrink_with_their_sections() -> None:
    shape = reference.bend_dorsal(PAPER, 0.1, 1.0)
    solids = build_solids(PAPER, shape, 1.0)
    sizes = _size_dots(solids, 500.0)
    assert sizes.size == solids.is_shut.sum() > 5
    assert (np.diff(sizes) <= 0).all()
    assert sizes[-1] < sizes[0] <= 4.0
