"""Long work of the tab, and what is said and drawn of its results."""

import pathlib
import zipfile
from dataclasses import replace

import numpy as np
import pytest

from spiraltrunk.design import load_design
from spiraltrunk.errors import TakeError
from spiraltrunk.studio.drawing.axis_end import round_up
from spiraltrunk.studio.measure import jobs, texts
from spiraltrunk.studio.measure.error_scale import GAP, color_distances
from spiraltrunk.studio.measure.take_folder import StoredTake
from spiraltrunk.studio.measure.take_map import draw_map, mark_moment


def ignore(_):
    """No report."""


def test_a_virtual_session_is_reproducible_and_compared(virtual, question, tmp_path):
    again = jobs.record_virtual(ignore, question.design, "rest-045", 0, str(tmp_path / "again"))
    assert pathlib.Path(again[0]).read_bytes() == (virtual / "rest-045_1.csv").read_bytes()
    told = []
    (run,), result = jobs.compare_takes(told.append, question)
    assert run.name == "rest-045"
    assert len(run.takes) == 2
    assert result["is_made_up"]
    assert result["runs"]["rest-045"]["mean_rmse_m"] == pytest.approx(run.deviation.mean_rmse)
    assert told[0] == ("reading rest-045", 0, 2)


def test_a_bad_file_gives_the_reader_s_own_line(question, tmp_path):
    bad = tmp_path / "upload_1.csv"
    bad.write_text("no,take\n")
    with pytest.raises(TakeError, match=r"upload_1\.csv") as raised:
        jobs.compare_takes(ignore, replace(question, takes={"rest-045": [str(bad)]}))
    assert "\n" not in str(raised.value)


def test_the_report_is_that_of_the_command(question, tmp_path):
    with zipfile.ZipFile(jobs.write_report(ignore, question, str(tmp_path))) as packed:
        names = set(packed.namelist())
    assert {"report.html", "result.json", "deviations.csv", "overlay-rest.png"} <= names


@pytest.mark.slow
def test_a_calibration_returns_design_and_files(question, tmp_path):
    result, design, packed = jobs.calibrate_takes(ignore, question, 200.0, str(tmp_path))
    assert load_design(design).name == "paper, calibrated"
    with zipfile.ZipFile(packed) as files:
        assert "calibration.png" in files.namelist()
    held = result["held_out"]["all"]
    assert held["calibrated_mean_rmse_m"] < held["uncalibrated_mean_rmse_m"]
    assert f"{1e3 * held['calibrated_mean_rmse_m']:.2f} mm calibrated" in texts.format_calibration(result)


def test_the_words_name_run_shape_and_gaps(question):
    (run,), result = jobs.compare_takes(ignore, question)
    text = texts.format_moment(run, 0, 0, result)
    assert f"mean RMSE {1e3 * run.deviation.mean_rmse:.1f} mm" in text
    assert "rest, tilt 45 deg" in text
    gaps = run.takes[0].list_gaps(0)
    assert ("Gaps at this moment: none" in text) == (gaps == [])
    assert "Synthetic" in text


def test_names_from_the_page_are_escaped():
    text = texts.format_takes([StoredTake(run="twist", file="f", name="<script>")])
    assert "<script>" not in text


def test_colours_run_from_dark_to_light_and_gaps_are_grey():
    colors = color_distances(np.array([0.0, 0.5, 2.0, np.nan]), 1.0)
    assert colors[0] == pytest.approx([68, 1, 84])
    assert colors[2] == pytest.approx([253, 231, 37])
    assert colors[3] == pytest.approx(GAP)
    assert colors[0].sum() < colors[1].sum() < colors[2].sum()


def test_the_map_has_time_across_and_the_tip_above():
    distance = np.zeros((360, 3))
    distance[180:, 2] = 1.0
    distance[0, 0] = np.nan
    picture = draw_map(distance, np.array([True, False, True]), 1.0)
    assert picture.shape == (10, 360, 3)
    assert tuple(picture[0, 359]) == (253, 231, 37)
    assert tuple(picture[0, 0]) == (68, 1, 84)
    assert tuple(picture[9, 0]) == GAP
    marked = mark_moment(picture, 1.0)
    assert tuple(marked[5, 359]) == (213, 94, 0)
    assert tuple(picture[5, 359]) != (213, 94, 0)


@pytest.mark.parametrize(("value", "end"), [(0.0, 1.0), (1.0, 1.0), (1.1, 2.0), (4.9, 5.0), (51.0, 100.0)])
def test_axes_end_at_round_numbers(value, end):
    assert round_up(value, 1.0) == pytest.approx(end)
