"""Pictures of rates: what is drawn are the numbers."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from hypothesis import example, given
from hypothesis import strategies as st
from PIL import Image

from spiraltrunk.report.style import write_figure
from spiraltrunk.report.survey import (
    Outcomes,
    build_causes_figure,
    build_heatmap_figure,
    build_rates_figure,
    compute_cells,
)

RATES = {
    "wrap-vertical": {"trials": 50, "successes": 48, "low": 0.865, "high": 0.989},
    "kick": {"trials": 0, "successes": 0, "low": 0.0, "high": 1.0},
}


def build_outcomes(name: str = "wrap-vertical", count: int = 40) -> Outcomes:
    rng = np.random.default_rng(3)
    width, mass = rng.uniform(0.03, 0.12, count), rng.uniform(0.1, 0.5, count)
    return Outcomes(name=name, width=list(width), mass=list(mass), success=list(mass < 0.3))


def test_dots_and_lines_are_rates_and_intervals(tmp_path: Path) -> None:
    axes = build_rates_figure(RATES).axes[0]
    line, dot, empty = axes.lines
    assert list(line.get_xdata()) == [86.5, 98.9]
    assert list(dot.get_xdata()) == [96.0]
    assert list(empty.get_xdata()) == [0.0, 100.0]
    assert [text.get_text() for text in axes.texts] == ["48 of 50", "0 of 0"]
    assert [text.get_text() for text in axes.get_yticklabels()] == ["wrap-vertical", "kick"]
    with Image.open(write_figure(build_rates_figure(RATES), tmp_path / "rates.png")) as picture:
        assert picture.width > 800


def test_a_name_as_long_as_a_path_leaves_room_for_the_rates() -> None:
    name = f"policy:/{40 * 'folder/'}kick.safetensors"
    figure = build_rates_figure({name: {"trials": 4, "successes": 2, "low": 0.1, "high": 0.9}})
    (axes,) = figure.axes
    figure.draw_without_rendering()
    assert axes.get_position().width > 0.4
    (label,) = axes.get_yticklabels()
    assert label.get_text().startswith("policy:/")
    assert label.get_text().endswith("kick.safetensors")


def test_cells_of_causes_are_numbers_of_failures() -> None:
    by_strategy = {
        "kick": {"trials": 9, "causes": {"missed": 2, "toppled": 1}},
        "sweep": {"trials": 8, "causes": {"missed": 3}},
    }
    by_class = {"cylinder, 45 to 80 mm": {"trials": 17, "causes": {"toppled": 1, "missed": 5}}}
    first, second = build_causes_figure(by_strategy, by_class).axes
    assert [text.get_text() for text in first.get_yticklabels()] == ["kick (9)", "sweep (8)"]
    for axes in (first, second):
        assert [text.get_text() for text in axes.get_xticklabels()] == ["missed", "toppled"]
    cells = {(*text.get_position(), text.get_text()) for text in first.texts}
    assert cells == {(0.5, 0.5, "2"), (1.5, 0.5, "1"), (0.5, 1.5, "3")}
    assert {text.get_text() for text in second.texts} == {"5", "1"}


def test_without_failures_there_is_a_table_all_the_same(tmp_path: Path) -> None:
    figure = build_causes_figure({"kick": {"trials": 9, "causes": {}}}, {})
    assert not figure.axes[0].texts
    write_figure(figure, tmp_path / "causes.png")


measures = st.lists(st.tuples(st.floats(0.005, 0.999), st.floats(0.001, 19.0), st.booleans()), min_size=1, max_size=40)


@given(measures)
@example([(0.0055, 1.0, False), (0.005, 1.0, False)])
def test_every_trial_is_in_one_cell(trials: list[tuple[float, float, bool]]) -> None:
    width, mass, success = zip(*trials, strict=True)
    width_mm, mass_g, count, successes = compute_cells(Outcomes(name="x", width=width, mass=mass, success=success))
    assert count.sum() == len(trials)
    assert successes.sum() == sum(success)
    assert (successes <= count).all()
    assert count.shape == (len(width_mm) - 1, len(mass_g) - 1)
    assert (np.diff(width_mm) > 0).all()


def test_cells_lie_where_their_trials_are() -> None:
    outcomes = Outcomes(name="x", width=[0.031, 0.119, 0.118], mass=[0.11, 0.49, 0.48], success=[True, False, True])
    _, _, trials, successes = compute_cells(outcomes)
    assert (trials[0, 0], successes[0, 0]) == (1, 1)
    assert (trials[-1, -1], successes[-1, -1]) == (2, 1)


def test_the_sheet_has_a_map_for_each_and_its_counts(tmp_path: Path) -> None:
    sheet = [build_outcomes(name) for name in ("a", "b", "c")] + [Outcomes(name="none", width=[], mass=[], success=[])]
    figure = build_heatmap_figure(sheet)
    maps = figure.axes[:4]
    _, _, trials, successes = compute_cells(sheet[0])
    assert [axes.get_title() for axes in maps] == [
        f"{one.name}: {sum(one.success)} of {len(one.success)}" for one in sheet
    ]
    told = sorted(text.get_text() for text in maps[0].texts)
    assert told == sorted(f"{successes[i, j]}/{trials[i, j]}" for i, j in np.argwhere(trials))
    drawn = maps[0].collections[0].get_array()
    assert np.ma.count_masked(drawn) == (trials == 0).sum()
    assert not maps[3].collections
    with Image.open(write_figure(figure, tmp_path / "heatmap.png")) as picture:
        assert picture.width > 1000


def test_a_sheet_of_nothing_is_drawn(tmp_path: Path) -> None:
    assert write_figure(build_heatmap_figure([]), tmp_path / "heatmap.png").stat().st_size > 0
