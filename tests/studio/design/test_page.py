"""The tab "Design" in a browser: its picture and figures follow a parameter, and a file comes back as it was saved."""

from dataclasses import replace

import pytest

from spiraltrunk.design import format_design, presets
from spiraltrunk.design.toml import parse_design
from spiraltrunk.studio.design.tab import DesignTab

WIDER = parse_design(format_design(presets.get("spirob-1m")).encode(), "wider.toml")


def test_a_parameter_changes_picture_figures_and_file(studio, open_page, take_picture, tmp_path):
    page = open_page(studio([DesignTab]))
    page.get_by_text("194.5 g").wait_for()
    page.wait_for_timeout(1000)
    before = take_picture(page, "before")
    assert (before.std(axis=(0, 1)) > 5).all()  # Something is drawn.
    slider = page.get_by_role("slider").filter(visible=True).first
    slider.focus()
    for _ in range(5):
        slider.press("ArrowRight")
    page.get_by_text("194.5 g").wait_for(state="detached")
    page.wait_for_timeout(1000)
    assert (abs(take_picture(page, "after") - before).sum(axis=2) > 60).mean() > 0.005
    with page.expect_download() as download:
        page.get_by_role("button", name="Save trunk.toml").click()
    saved = parse_design(download.value.path().read_bytes(), "saved")
    assert saved != replace(presets.PAPER, name=saved.name)
    assert saved.spiral.b != presets.PAPER.spiral.b


@pytest.mark.slow
def test_a_file_is_loaded_and_a_bad_one_is_one_line(studio, open_page, tmp_path):
    page = open_page(studio([DesignTab]))
    page.get_by_text("194.5 g").wait_for()
    good, bad = tmp_path / "good.toml", tmp_path / "bad.toml"
    good.write_text(format_design(WIDER))
    bad.write_text("schema = 1\nwidth = 3\n")
    with page.expect_file_chooser() as chooser:
        page.get_by_role("button", name="Load trunk.toml").click()
    chooser.value.set_files(bad)
    page.get_by_text("That did not work").wait_for()
    assert page.get_by_text("194.5 g").is_visible()
    with page.expect_file_chooser() as chooser:
        page.get_by_role("button", name="Load trunk.toml").click()
    chooser.value.set_files(good)
    page.get_by_text("194.5 g").wait_for(state="detached")
