"""Pictures and page of measured shapes show what they are given."""

from __future__ import annotations

import numpy as np
import pytest

from spiraltrunk.report.page import build_heading, build_list, build_paragraphs, build_picture, build_table, write_page
from spiraltrunk.report.shape.comparison import (
    MOST_SHAPES,
    ShapeComparison,
    build_boxes_figure,
    build_overlay_figure,
    choose_shapes,
)
from spiraltrunk.report.style import write_figure


def judged(count=8, n_section=6):
    rng = np.random.default_rng(0)
    predicted = np.cumsum(rng.normal(0.03, 0.01, (count, n_section, 3)), axis=1)
    measured = predicted + rng.normal(0, 0.004, predicted.shape)
    measured[2:3, 3] = np.nan
    measured[:, 5] = np.nan
    labels = tuple(f"{5 * i}" for i in range(count))
    return ShapeComparison(
        title="bend: $5", labels=labels, label="Cable 1 in by [mm]", measured=measured, predicted=predicted
    )


def test_boxes_hold_every_distance_that_was_seen():
    given = judged()
    left, right = build_boxes_figure(given).axes
    assert left.get_xlabel() == "Cable 1 in by [mm]"
    assert [tick.get_text() for tick in right.get_xticklabels()] == ["1", "2", "3", "4", "5"]
    root = next(line for line in left.lines if line.get_marker() == "D")
    expected = 1e3 * np.sqrt(np.nanmean(given.distance[:, :5] ** 2, axis=1))
    np.testing.assert_allclose(root.get_ydata(), expected)
    assert left.get_ylim()[0] == 0


def test_the_worst_shape_is_always_drawn():
    given = judged(27)
    given.measured[11, 0] += 0.5
    chosen = choose_shapes(given)
    assert {0, 11, 26} <= set(chosen)
    assert len(chosen) == MOST_SHAPES
    assert choose_shapes(judged(1)) == [0]
    assert choose_shapes(judged(2)) == [0, 1]


def test_an_overlay_draws_lines_and_dots():
    given = judged(3)
    space, side, end = build_overlay_figure(given).axes
    assert (side.get_xlabel(), end.get_xlabel(), space.get_xlabel()) == ("x [mm]", "z [mm]", "x [mm]")
    across = [line for line in side.lines if len(line.get_xdata()) == 2]
    lines = [line for line in side.lines if line.get_marker() == "None" and line not in across]
    dots = [line for line in side.lines if line.get_marker() == "o"]
    assert len(lines) == len(dots) == 3
    np.testing.assert_allclose(lines[1].get_ydata()[1:], 1e3 * given.predicted[1, :, 1])
    np.testing.assert_allclose(dots[1].get_xdata(), 1e3 * given.measured[1, :, 0])
    assert len(across) == given.measured[..., 0].size
    ends = {(*line.get_xdata(), *line.get_ydata()) for line in across}
    first = np.stack([given.measured[0, 0], given.predicted[0, 0]]) * 1e3
    assert any(np.allclose(end, (*first[:, 0], *first[:, 1])) for end in ends)
    low, high = side.get_ylim()
    assert all(low < value < high for line in lines for value in line.get_ydata())


@pytest.mark.slow
def test_pictures_are_written(tmp_path):
    for build in (build_boxes_figure, build_overlay_figure):
        path = write_figure(build(judged(1)), tmp_path / "a.png")
        assert path.read_bytes()[:4] == b"\x89PNG"
    assert [path.name for path in tmp_path.iterdir()] == ["a.png"]


def test_a_page_holds_all_and_no_markup_of_others(tmp_path):
    picture = write_figure(build_boxes_figure(judged(2)), tmp_path / "a.png")
    evil = '<script>alert("1")</script> & co'
    blocks = [
        build_heading(evil), build_paragraphs([evil]), build_list([evil]), build_picture(picture, evil),
        build_table([evil, "b"], [(evil, "1")], evil),
    ]  # fmt: skip
    text = write_page(tmp_path / "page.html", evil, blocks).read_text()
    assert "<script" not in text
    assert text.count("&lt;script&gt;") == 9
    assert text.count("data:image/png;base64,") == 1
