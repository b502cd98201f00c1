"""The tab of the design in a real browser: its main act by keys and clicks."""

import io
import math
import time
import zipfile
from dataclasses import replace

import pytest

pytest.importorskip("viser", reason="viser is not installed")

from spiraltrunk.design import format_design, presets
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


def pick_preset(page, name):
    page.get_by_label("Preset", exact=True).filter(visible=True).first.click()
    page.get_by_role("option", name=name, exact=True).click()


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


def test_what_whole_sections_change_is_told_and_digits_are_kept(open_design):
    page, tab = open_design()
    adjusted = page.get_by_role("alert").filter(has_text="Adjusted")
    fill(box_of(page, "Turns"), "1.6")
    adjusted.filter(has_text="Turns: 1.6 \u2192 1.583 (19 sections)").wait_for(timeout=LONG)
    fill(box_of(page, "Turns"), "1.5")
    adjusted.wait_for(state="detached", timeout=LONG)
    box = box_of(page, "Ratio m")
    fill(box, "1.234567")
    wait_until(lambda: read_rules(tab._page.design).m == pytest.approx(1.234567, rel=1e-9))
    page.wait_for_timeout(2000)
    assert box.input_value() == "1.234567"
    assert adjusted.count() == 0


def test_measured_values_that_are_left_out_are_told_and_a_preset_is_no_own_design(open_design):
    page, _ = open_design()
    pick_preset(page, "own design")
    page.get_by_role("alert").filter(has_text="the design is the preset paper").wait_for(timeout=LONG)
    wait_until(lambda: page.get_by_label("Preset", exact=True).first.input_value() == "paper")
    fill(box_of(page, "Ratio m"), "1.6")
    page.get_by_role("alert").filter(has_text="measured values are left out").wait_for(timeout=LONG)
    wait_until(lambda: page.get_by_label("Preset", exact=True).first.input_value() == "own design")


class PlainTab:
    """A tab without controls."""

    name, title = "plain", "Plain"

    def __init__(self, page):
        pass

    def apply_settings(self, settings):
        pass

    def read_settings(self):
        return {}

    def build(self):
        pass

    show = hide = close = build


def test_viser_does_not_tell_again_that_a_file_has_arrived(studio, open_page, tmp_path):
    """Its client does, whenever the button is shown anew."""
    page = open_page(studio([DesignTab, PlainTab]))
    file = tmp_path / "own.toml"
    file.write_text(format_design(presets.get("spirob-15")))
    page.locator("input[type=file]").first.set_input_files(file)
    page.get_by_role("alert").filter(has_text="own.toml is the design now").wait_for(timeout=LONG)
    for title in ("Plain", "Design"):
        page.get_by_role("button", name=title, exact=True).click()
        page.get_by_role("button", name=title, exact=True, pressed=True).wait_for(timeout=LONG)
    told = page.locator(".mantine-Notification-root").filter(has_text="File uploaded successfully.")
    told.wait_for(state="attached", timeout=LONG)  # It is there,
    told.wait_for(state="hidden", timeout=2000)  # not seen, and goes by itself after 4 s.
    assert told.count() == 1


def test_ranges_go_back_after_an_extreme_value(open_design):
    page, tab = open_design()
    page.get_by_role("button", name="Spiral and sections (folder)").click()
    radius = page.get_by_role("slider", name="Radius a [mm]", exact=True)

    def read_ends():
        return tuple(float(radius.get_attribute(f"aria-value{end}")) for end in ("min", "max"))

    usual = read_ends()
    fill(box_of(page, "Ratio m"), "10")
    wait_until(lambda: read_ends() != usual)
    assert all(end == float(f"{end:.3g}") for end in read_ends())
    pick_preset(page, "paper")
    wait_until(lambda: tab._page.design == presets.PAPER)
    wait_until(lambda: read_ends() == usual)


def test_an_arm_that_cannot_be_is_refused_at_its_box(open_design, tmp_path):
    page, tab = open_design()
    page.get_by_role("button", name="Arm (folder)").click()
    home = page.get_by_role("textbox", name="Initial joints [deg]", exact=True)
    home.fill("1,2")
    told = page.get_by_role("alert").filter(has_text="allowed: 7 numbers, one per joint of the arm")
    told.filter(has_text="Initial joints [deg] is 2 numbers").wait_for(timeout=LONG)
    wait_until(lambda: home.input_value() == "")
    site = page.get_by_label("Mount site", exact=True).filter(visible=True).first
    site.click()
    assert page.get_by_role("option").filter(visible=True).all_inner_texts() == ["flange"]
    file = tmp_path / "nope.toml"
    file.write_text(format_design(presets.PAPER).replace('mount_site = "flange"', 'mount_site = "nope"'))
    page.locator("input[type=file]").first.set_input_files(file)
    words = "nope.toml: arm.mount_site is 'nope'; allowed: flange"
    page.get_by_role("alert").filter(has_text=words).wait_for(timeout=LONG)
    assert tab._page.design == presets.PAPER


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
    stale = page.get_by_text("of the design before its last change").filter(visible=True)
    fill(box_of(page, "Ratio m"), "1.7")
    stale.wait_for(timeout=LONG)
    pick_preset(page, "paper")
    stale.wait_for(state="detached", timeout=LONG)
    page.get_by_role("button", name="Make parts").click()
    page.get_by_role("button", name="Stop").wait_for()  # The page's thread has begun, and made the folder.
    folder = tab._parts._folder
    page.get_by_role("button", name="Stop").click()
    page.get_by_text("Stopped.").wait_for(timeout=LONG)
    assert not folder.exists()
