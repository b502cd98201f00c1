"""The tab in a real browser."""

import numpy as np
import pytest

from spiraltrunk.studio.measure.tab import MeasureTab

pytestmark = pytest.mark.slow  # A real browser, which draws by software: minutes in all.

LONG = 60_000
"""Time in which a take is read on a busy machine [ms]."""


def upload(page, file, *, number=0):
    """Choose a file for one of the upload buttons."""
    page.locator("input[type=file]").nth(number).set_input_files(file)


def test_an_uploaded_take_is_drawn_over_the_model(studio, open_page, take_picture, virtual):
    tabs = []
    page = open_page(studio([lambda one: tabs.append(MeasureTab(one)) or tabs[-1]]))
    page.get_by_text("No recording yet").wait_for()
    note = tabs[0]._picture._note
    assert (note.text, note.visible) == ("the design; no recording yet", True)
    for _ in range(60):
        page.wait_for_timeout(500)
        before = take_picture(page, "empty")
        if is_trunk := (before[200:620, 380:500].max(axis=2) < 220).mean() > 0.2:
            break
    assert is_trunk
    upload(page, virtual / "rest-045_1.csv")
    page.get_by_text("mean RMSE").wait_for(timeout=LONG)
    page.get_by_text("rest-045_1.csv").first.wait_for()
    page.wait_for_timeout(1000)
    assert (np.abs(take_picture(page, "overlay") - before).max(axis=-1) > 40).sum() > 2000
    assert not note.visible
    page.get_by_text("Synthetic takes, not a measurement.").wait_for()


@pytest.mark.slow
def test_a_bad_file_is_told_in_one_line_and_forgotten(studio, open_page, tmp_path):
    page = open_page(studio([MeasureTab]))
    bad = tmp_path / "twist_1.csv"
    bad.write_text("no,take\n")
    upload(page, bad)
    page.get_by_text("No comparison:").wait_for(timeout=LONG)
    assert page.get_by_text("upload_1").count() == 0
    page.get_by_text("No takes.").wait_for()


@pytest.mark.slow
def test_virtual_session_calibration_and_a_reload(studio, open_page):
    page = open_page(studio([MeasureTab]))
    page.get_by_role("button", name="Record a virtual session").click()
    page.get_by_text("Shape 27 of 27").wait_for(timeout=2 * LONG)
    page.get_by_role("tab", name="Calibrate").click()
    page.get_by_role("button", name="Calibrate", exact=True).click()
    page.get_by_text("Reading ...").or_(page.get_by_text("Fitting")).first.wait_for(timeout=LONG)
    page.get_by_role("button", name="Stop").click()
    page.get_by_text("Stopped.").wait_for()
    page.get_by_role("button", name="Calibrate", exact=True).click()
    page.get_by_text("mm calibrated").wait_for(timeout=5 * LONG)
    with page.expect_download() as download:
        page.get_by_role("button", name="Download the calibration").click()
    assert download.value.suggested_filename == "calibration.zip"
    page.get_by_role("button", name="Use the calibrated design").click()
    page.get_by_text("all tabs show the calibrated design").wait_for(timeout=LONG)
    page.reload()
    page.get_by_text("Shape 27 of 27").wait_for(timeout=2 * LONG)
