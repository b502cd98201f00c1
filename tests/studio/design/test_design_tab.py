"""The tab of the design in a real browser: its main act by keys and clicks."""

import io
import math
import time
import zipfile
from dataclasses import replace

import pytest

pytest.importorskip("viser", reason="viser is not installed")

from spiraltrunk.design import presets
from spiraltrunk.design.edit import change_rules, read_rules
from spiraltrunk.design.toml import parse_design
from spiraltrunk.studio.design.tab import DesignTab

pytestmark = pytest.mark.slow  # A real browser, which draws by software: minutes in all.

LONG = 60_000


@pytest.fixture
def open_design(studio, open_page):
    """Opens a page on the tab; gives the page and its tab."""
    tabs = []

    def build(page):
        tabs.append(DesignTab(page))
        return tabs[-1]

    def start(design=presets.PAPER):
        page = open_page(studio([build], design=design))
        page.get_by_text("Rules of the paper").wait_for(timeout=LONG)
        page.get_by_role("alert").get_by_role("button").first.click()  # That WebGL is drawn by software.
        return page, tabs[-1]

    return start


def box_of(page, label):
    """Number box of the slider of that label."""
    row = page.locator("div:has(> div label)", has=page.get_by_text(label, exact=True)).last
    return row.get_by_role("textbox").last


def fill(box, text):
    box.fill(text)
    box.press("Enter")


def wait_until(holds, seconds=30.0):
    end = time.monotonic() + seconds
    while not holds() and time.monotonic() < end:
        time.sleep(0.05)
    assert holds()


def test_a_rule_by_keyboard_changes_picture_figures_and_file(open_design, take_picture, tmp_path):
    page, tab = open_design()
    page.get_by_text("32.6 to 268 mm").wait_for(timeout=LONG)
    page.wait_for_timeout(500)
    before = take_picture(page, "before")
    box = box_of(page, "Ratio m")
    fill(box, "2.5")
    wait_until(lambda: tab._page.design == replace(change_rules(presets.PAPER, m=2.5), name="my-paper"))
    page.get_by_text("32.6 to 268 mm").wait_for(state="detached", timeout=LONG)
    page.wait_for_timeout(500)
    assert (abs(take_picture(page, "after") - before).sum(axis=2) > 60).mean() > 0.01
    with page.expect_download(timeout=LONG) as download:
        page.get_by_role("button", name="Save trunk.toml").click()
    file = tmp_path / "mine.toml"
    download.value.save_as(file)
    saved = parse_design(file.read_bytes(), file)
    assert saved == tab._page.design
    fill(box, "1")
    wait_until(lambda: tab._page.design != saved)
    page.locator("input[type=file]").first.set_input_files(file)
    wait_until(lambda: tab._page.design == saved)


def find_distance(tab):
    camera = tab._page.client.camera
    return math.dist(camera.position, camera.look_at)


def test_the_camera_follows_the_size_at_rest_unless_a_person_moved_it(open_design):
    page, tab = open_design()
    page.wait_for_timeout(1500)
    first, box = find_distance(tab), box_of(page, "Arm radius [mm]")
    fill(box, "27")  # 0.61 of the size before: too little a change to move the camera while a slider is dragged.
    wait_until(lambda: find_distance(tab) == pytest.approx(27 / 44 * first, rel=0.02))
    fill(box, "36")
    page.wait_for_timeout(2500)
    assert find_distance(tab) == pytest.approx(36 / 44 * first, rel=0.02)
    page.mouse.move(400, 500)
    page.mouse.down()
    page.mouse.move(520, 470, steps=5)
    page.mouse.up()
    page.wait_for_timeout(1500)
    turned = tuple(tab._page.client.camera.position)
    for size in ("15", "120"):
        fill(box, size)
        wait_until(lambda size=size: read_rules(tab._page.design).arm_radius == pytest.approx(float(size) / 1e3))
        page.wait_for_timeout(1500)
        assert tuple(tab._page.client.camera.position) == pytest.approx(turned)
    page.get_by_role("checkbox", name="Construction").uncheck()
    wait_until(lambda: find_distance(tab) > 2 * first)


def test_a_refused_change_is_told_and_goes_back(open_design):
    page, tab = open_design()
    box = box_of(page, "Turns")
    fill(box, "5")
    wait_until(lambda: tab._page.design.n_section == 60)
    wide = tab._page.design
    ratio = box_of(page, "Ratio m")
    fill(ratio, "0.2")
    page.get_by_role("alert").filter(has_text="width of the tip").wait_for(timeout=LONG)
    assert tab._page.design == wide
    wait_until(lambda: ratio.input_value() == "1.531")


def test_a_file_that_is_no_design_changes_nothing(open_design, tmp_path):
    page, tab = open_design()
    file = tmp_path / "bad.toml"
    file.write_text('name = "x"\n[spiral]\na_mm = -1\n')
    page.locator("input[type=file]").first.set_input_files(file)
    page.get_by_role("alert").filter(has_text="bad.toml").wait_for(timeout=LONG)
    assert tab._page.design == presets.PAPER


@pytest.mark.slow
def test_parts_are_made_and_offered_or_stopped(open_design, tmp_path):
    pytest.importorskip("build123d", reason="solids need the extra cad")
    page, tab = open_design()
    page.get_by_text("Printable parts", exact=True).click()
    tab._parts._group._value = "drums"
    page.get_by_role("button", name="Make parts").click()
    with page.expect_download(timeout=4 * LONG) as download:
        page.get_by_role("button", name="Download parts").click(timeout=4 * LONG)
    download.value.save_as(tmp_path / "parts.zip")
    with zipfile.ZipFile(io.BytesIO((tmp_path / "parts.zip").read_bytes())) as archive:
        assert "parts/drum.stl" in archive.namelist()
    page.get_by_role("button", name="Make parts").click()
    page.get_by_role("button", name="Stop").wait_for()  # The page's thread has begun, and made the folder.
    folder = tab._parts._folder
    page.get_by_role("button", name="Stop").click()
    page.get_by_text("Stopped.").wait_for(timeout=LONG)
    assert not folder.exists()
