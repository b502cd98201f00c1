"""Plots show the numbers where they say, with nothing cut off or covered."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.image import imread

from spiraltrunk.report import Series, write_plots
from spiraltrunk.report.style import write_figure
from spiraltrunk.report.trial.figures import FIGURES, build_run_figure
from spiraltrunk.report.trial.phase_bands import place_labels


def draw(figure: Figure) -> np.ndarray:
    """Pixels of a figure, the lowest row first."""
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    return np.asarray(canvas.buffer_rgba())[::-1]


def test_cables_show_millimetres_and_newtons(series: Series) -> None:
    pull, tension = build_run_figure(series, "cables.png").axes
    for axes, values in ((pull, 1e3 * series.cable_pull), (tension, series.cable_tension)):
        lines, labels = axes.get_legend_handles_labels()
        assert labels == ["cable 1 (dorsal)", "cable 2", "cable 3"]
        for cable, line in enumerate(lines):
            np.testing.assert_array_equal(line.get_ydata(), values[:, cable])
            np.testing.assert_array_equal(line.get_xdata(), series.time)
        assert len({line.get_color() for line in lines}) == 3
    assert "mm" in pull.get_ylabel()
    assert "[N]" in tension.get_ylabel()


def test_heat_map_shows_the_tip_where_it_says_tip(build: Callable[..., Series]) -> None:
    bend = np.zeros((120, 17))
    bend[:, -1], bend[60:, 0] = 0.3, 0.5
    figure = build_run_figure(build(joint_bend=bend), "joints.png")
    pixels = draw(figure)
    axes = figure.axes[0]
    (mesh,) = (one for one in axes.collections if one.get_array() is not None)
    rows = {
        label.get_text().split()[0]: tick for tick, label in zip(axes.get_yticks(), axes.get_yticklabels(), strict=True)
    }
    assert rows["tip"] > rows["base"]
    for row, time, expected in (("tip", 4.5, 0.3), ("base", 4.5, 0.0), ("tip", 8.5, 0.3), ("base", 8.5, 0.5)):
        x, y = axes.transData.transform((time, rows[row]))
        color = np.array(mesh.cmap(mesh.norm(np.degrees(expected))))
        np.testing.assert_allclose(pixels[int(y), int(x)] / 255, color, atol=0.01)


def test_color_bar_names_the_limit(series: Series) -> None:
    figure = build_run_figure(series, "joints.png")
    draw(figure)
    bar = figure.axes[0].child_axes[0]
    ticks = {label.get_text(): tick for tick, label in zip(bar.get_yticks(), bar.get_yticklabels(), strict=True)}
    assert ticks["30 limit"] == pytest.approx(30.0)
    assert any(np.allclose(line.get_ydata(), 30.0) for line in bar.lines)
    assert bar.get_ylim()[1] > 30.0


def test_bend_beyond_the_limit_is_told_apart(build: Callable[..., Series], series: Series) -> None:
    figure = build_run_figure(build(joint_bend=2.0 * series.joint_bend), "joints.png")
    (mesh,) = (one for one in figure.axes[0].collections if one.get_array() is not None)
    assert mesh.get_clim()[1] == pytest.approx(np.degrees(2.0 * series.joint_bend.max()))


def test_front_is_shown_in_parts_of_the_length(build: Callable[..., Series]) -> None:
    bend = np.zeros((120, 17))
    bend[30:, 10:], bend[60:, 5:] = 0.5, 0.5
    series = build(joint_bend=bend)
    (axes,) = build_run_figure(series, "curvature.png").axes
    (line,) = axes.get_legend_handles_labels()[0]
    length = series.section_length
    expected = np.repeat([0.0, length[11:].sum(), length[6:].sum()], [30, 30, 60]) / length.sum()
    np.testing.assert_allclose(line.get_ydata(), 100 * expected, rtol=0, atol=1e-9)
    ticks = {label.get_text(): tick for tick, label in zip(axes.get_yticks(), axes.get_yticklabels(), strict=True)}
    assert (ticks["0  tip"], ticks["100  base"]) == (0.0, 100.0)
    assert axes.get_ylim() == (0.0, 100.0)


@pytest.mark.parametrize("lift", [(0.9, 1.1), None])
def test_object_shows_its_lift(build: Callable[..., Series], lift: tuple[float, float] | None) -> None:
    (axes,) = build_run_figure(build(lift=lift), "object.png").axes
    lines, labels = axes.get_legend_handles_labels()
    assert labels == (["object"] if lift is None else ["object", "lift start", "lift target"])
    if lift is not None:
        assert [line.get_linestyle() for line in lines[1:]] == [":", "--"]
        assert [set(line.get_ydata()) for line in lines[1:]] == [{height} for height in lift]


def test_forces_are_told_apart(series: Series) -> None:
    (axes,) = build_run_figure(series, "force.png").axes
    shown = dict(zip(*axes.get_legend_handles_labels()[::-1], strict=True))
    np.testing.assert_array_equal(shown["contact force"].get_ydata(), series.grip_force)
    np.testing.assert_array_equal(shown["string tension"].get_ydata(), series.string_tension)


def test_overview_shares_its_time(series: Series) -> None:
    columns = build_run_figure(series, "overview.png").axes
    assert len(columns) == 6
    assert all(columns[0].get_shared_x_axes().joined(columns[0], axes) for axes in columns)
    assert [axes.get_xlabel() for axes in columns] == ["", "", "", "", "", "Time [s]"]


@pytest.mark.parametrize(
    ("name", "spans"),
    [
        pytest.param(
            name,
            spans,
            marks=[] if spans == "even" or (name, spans) == ("overview.png", "beyond") else [pytest.mark.slow],
        )
        for name in FIGURES
        for spans in ("even", "short", "beyond", "none")
    ],
)
def test_nothing_is_cut_off_or_covered(build: Callable[..., Series], name: str, spans: str) -> None:
    changes = {
        "even": {},
        "short": {"phase_spans": (("reach", 0.0, 0.2), ("prehension", 0.3, 0.5), ("transport", 0.6, 12.0))},
        "beyond": {"phase_spans": (("reach", -9.0, 6.0), ("release", 6.0, 40.0), ("later", 50.0, 60.0))},
        "none": {"phase_spans": (), "title": ""},
    }[spans]
    figure = build_run_figure(build(**changes), name)
    draw(figure)
    drawn = figure.get_tightbbox()
    assert (drawn.min >= 0.0).all()
    assert (drawn.max <= figure.get_size_inches()).all()
    for axes in figure.axes:
        if axes.get_legend() is not None:
            assert not axes.get_legend().get_window_extent().overlaps(axes.bbox)
    labels = [text.get_window_extent() for text in figure.axes[0].texts]
    assert not any(one.overlaps(other) for i, one in enumerate(labels) for other in labels[:i])


def test_phases_are_named_over_the_first_axes(series: Series) -> None:
    first, *others = build_run_figure(series, "overview.png").axes
    assert [text.get_text() for text in first.texts] == ["reach", "prehension", "transport", "release"]
    assert [text.get_position()[0] for text in first.texts] == pytest.approx([0.95, 3.45, 7.45, 11.0])
    assert not any(axes.texts for axes in others)


@given(
    st.lists(st.tuples(st.text("abc", min_size=1, max_size=12), st.floats(0.0, 10.0)), max_size=9), st.floats(0.01, 0.4)
)
def test_labels_never_touch(lengths: list[tuple[str, float]], letter: float) -> None:
    ends = np.cumsum([length for _, length in lengths])
    right = max(1.0, float(ends[-1])) if lengths else 1.0
    spans = [(name, float(end - length), float(end)) for (name, length), end in zip(lengths, ends, strict=True)]
    labels = place_labels(spans, letter=letter, left=0.0, right=right)
    edge = -letter
    for name, _, place in labels:
        half = (len(name) + 1) * letter / 2
        assert place - half >= edge - 1e-9
        edge = place + half
    assert edge <= right + letter + 1e-9
    if sum(len(name) + 1 for name, _ in lengths) * letter <= right:
        assert [name for name, _, _ in labels] == [name for name, _ in lengths]


@pytest.mark.slow
def test_files_are_written(series: Series, tmp_path: Path) -> None:
    folder = tmp_path / "new" / "plots"
    paths = write_plots(series, folder)
    assert [path.name for path in paths] == [
        "cables.png",
        "joints.png",
        "curvature.png",
        "object.png",
        "force.png",
        "overview.png",
    ]
    assert sorted(folder.iterdir()) == sorted(paths)
    for path in paths:
        pixels = imread(path)
        assert pixels.shape[1] == 1140
        assert pixels[..., :3].std() > 0.05


def test_failing_writer_leaves_the_old_file(series: Series, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    figure = build_run_figure(series, "overview.png")
    path = write_figure(figure, tmp_path / "overview.png")
    before = path.read_bytes()

    def fail(self: Figure, file: Path, **settings: object) -> None:
        file.write_bytes(b"half a pic")
        raise OSError("no space left")

    monkeypatch.setattr(Figure, "savefig", fail)
    with pytest.raises(OSError, match="no space left"):
        write_figure(figure, path)
    assert list(tmp_path.iterdir()) == [path]
    assert path.read_bytes() == before


def test_import_is_light() -> None:
    program = (
        "import sys, spiraltrunk.report\n"
        "print(*(name for name in ('matplotlib', 'PIL', 'av', 'mujoco') if name in sys.modules))"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout.split() == []
