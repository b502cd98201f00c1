"""The tab in a real browser."""

import math
import re
from types import SimpleNamespace

import numpy as np
import pytest
from viser import transforms

from spiraltrunk.design import presets
from spiraltrunk.studio.design.parameters import space_cables
from spiraltrunk.studio.design.tab import DesignTab
from spiraltrunk.studio.page.page import Page
from spiraltrunk.studio.shape import tab as shape_tab
from spiraltrunk.studio.shape.compile_models import compile_models
from spiraltrunk.studio.shape.tab import ShapeTab

pytestmark = pytest.mark.slow  # A real browser, which draws by software: minutes in all.

STROKE = 1e3 * presets.PAPER.cable_stroke
END = math.floor(STROKE)
PULLS = {
    "Rest": [-END] * 3,
    "Ventral": [-END, 0.35 * STROKE, 0.35 * STROKE],
    "Twist": [0.6 * STROKE, -0.1 * STROKE, -END],
}
"""Pulls at one click as the boxes show them, whose scales end at whole millimetres [mm]."""

CABLE = re.compile(r"^Cable \d+ \[mm\]$")

LONG = 60_000
"""Time in which the models are loaded or compiled on a busy machine [ms]."""


@pytest.fixture
def open_shape(studio, open_page, monkeypatch):
    """Opens the tab with its models compiled: ``open_shape()`` gives studio and page."""
    compile_models(lambda _: None, presets.PAPER)
    monkeypatch.setattr(shape_tab, "_compiled", {False})

    def start():
        one = studio([ShapeTab])
        page = open_page(one)
        page.get_by_text("Tension of cable").wait_for(timeout=LONG)
        return one, page

    return start


def type_pull(page, cable, value):
    """Type a pull [mm] into the number box of a cable, from 1."""
    box = page.locator("input[type=text]").nth(cable - 1)
    box.fill(value)
    box.press("Enter")


def read_pulls(page):
    """Pulls that the number boxes of the cables show [mm]."""
    boxes = page.locator("input[type=text]:visible")
    return [float(boxes.nth(i).input_value()) for i in range(page.get_by_text(CABLE).filter(visible=True).count())]


def read_tip(page):
    """Place of the tip that the page tells [mm]."""
    told = page.get_by_text("Tip x").filter(visible=True).first.inner_text()
    return [float(value) for value in re.search(r"x (-?\d+), y (-?\d+), z (-?\d+) mm", told).groups()]


def project(page, point):
    """Place of a point of the model on the screen [px]."""
    camera = page.client.camera
    x, y, z = point
    away = transforms.SO3(np.array(camera.wxyz)).as_matrix().T @ (np.array([x, -z, y]) - camera.position)
    size = np.array([camera.image_width, camera.image_height])
    return size / 2 + size[1] / 2 / np.tan(camera.fov / 2) * away[:2] / away[2]


def test_a_cable_is_pulled_and_trunk_words_and_handles_follow(open_shape, take_picture):
    _, page = open_shape()
    page.wait_for_timeout(1000)
    before = take_picture(page, "dorsal")
    type_pull(page, 1, "40")
    page.get_by_text("cable 1 in by 40.0 mm").wait_for(timeout=LONG)
    page.wait_for_timeout(1000)
    assert (np.abs(take_picture(page, "less") - before).max(axis=-1) > 40).sum() > 2000
    page.get_by_role("tab", name="Mean and differences").click()
    page.wait_for_function("[...document.querySelectorAll('input')].some((one) => one.value == '169.9')")


@pytest.mark.slow
def test_a_reload_with_another_design_writes_into_nothing_that_is_gone(studio, open_page, monkeypatch):
    compile_models(lambda _: None, presets.PAPER)
    monkeypatch.setattr(shape_tab, "_compiled", {False})
    one = studio([DesignTab, ShapeTab], first="Shape")
    page = open_page(one)
    page.get_by_text("Tension of cable").wait_for(timeout=LONG)
    told = []
    page.on("console", lambda message: told.append(message.text))
    page.get_by_role("button", name="Design", exact=True).click()
    (open_one, _), *_ = one._pages.values()
    four = space_cables(presets.PAPER, 4)
    open_one.post(lambda: open_one.set_design(four))
    page.get_by_role("button", name="Shape", exact=True).click()
    boxes = page.locator("input[type=text]:visible")
    page.get_by_text("Cable 4").filter(visible=True).first.wait_for(timeout=LONG)
    boxes.first.fill("40")
    boxes.first.press("Enter")
    page.wait_for_timeout(1500)
    before = read_pulls(page)
    assert (len(before), before[0]) == (4, 40.0)
    page.reload()
    page.get_by_text("Cable 4").filter(visible=True).first.wait_for(timeout=LONG)
    page.wait_for_timeout(1500)
    assert read_pulls(page) == before
    assert [text for text in told if "non-existent" in text] == []
    assert any("Connected" in text for text in told), "the console is heard"


@pytest.mark.slow
def test_pulls_at_one_click_and_a_turned_base(open_shape):
    _, page = open_shape()
    page.get_by_role("button", name="Ventral").click()
    page.get_by_text("ventral cables in until cable 1 is").wait_for(timeout=LONG)
    assert read_pulls(page) == pytest.approx(PULLS["Ventral"], abs=0.1)
    page.get_by_role("button", name="Rest").click()
    page.get_by_text("Paper's model, rest").wait_for(timeout=LONG)
    assert read_pulls(page) == pytest.approx(PULLS["Rest"], abs=0.1)
    hanging = read_tip(page)
    assert hanging[0] == 0  # Straight down.
    page.get_by_role("tab", name="Base").click()
    box = page.locator("input[type=text]:visible").nth(1)
    box.fill("30")
    box.press("Enter")
    page.get_by_text("the paper's model has no roll").wait_for(timeout=LONG)
    assert read_tip(page) == hanging  # A roll about the vertical leaves it there.


@pytest.mark.slow
def test_the_tip_is_dragged_and_the_cables_follow(open_shape, take_picture):
    one, page = open_shape()
    page.wait_for_timeout(1000)
    inner = next(iter(one._pages.values()))[0]
    handle = inner.scene._handle_from_transform_controls_name["/shape/all/world/tip"]
    u, v = project(inner, handle.position)
    page.mouse.move(u, v)
    page.wait_for_timeout(300)
    page.mouse.down()
    for step in range(1, 9):
        page.mouse.move(u - 4 * step, v + 6 * step)
        page.wait_for_timeout(50)
    page.mouse.up()
    told = page.get_by_text(re.compile("Out of reach: the tip stays|The tip is where you hold it"))
    told.wait_for(timeout=LONG)
    page.wait_for_function("[...document.querySelectorAll('input')].every((one) => one.value != '90.9')")
    take_picture(page, "dragged")
    handle._impl.position = np.full(3, np.nan)  # As a page could send it.
    for act in handle._impl_aux.update_cb:
        act(SimpleNamespace(phase="end"))
    page.get_by_text("dragged to what is no place").wait_for(timeout=LONG)
    assert np.isfinite(handle.position).all()


@pytest.mark.slow
def test_a_reload_comes_back_to_the_same_pulls(open_shape):
    _, page = open_shape()
    type_pull(page, 1, "55")
    page.get_by_text("cable 1 in by 55.0 mm").wait_for(timeout=LONG)
    pulls, tip = read_pulls(page), read_tip(page)
    assert pulls[0] == 55.0
    page.reload()
    page.get_by_text("cable 1 in by 55.0 mm").wait_for(timeout=LONG)
    assert read_pulls(page) == pulls
    assert read_tip(page) == pytest.approx(tip, abs=2)  # Wound from rest this time [mm].


@pytest.mark.slow
def test_the_page_says_what_it_compiles_and_can_be_used_meanwhile(studio, open_page, monkeypatch):
    monkeypatch.setattr(shape_tab, "_compiled", set())
    ends = []

    def start(inner, work, *arguments, on_report, on_end):
        assert work is compile_models
        inner.post(lambda: on_report("inverse model (3 of 3)"))
        ends.append(lambda: inner.post(lambda: on_end(None, None)))

    monkeypatch.setattr(Page, "start", start)  # It ends when it is told to.
    page = open_page(studio([ShapeTab]))
    page.get_by_text("Compiling the models: inverse model (3 of 3)").wait_for()
    page.get_by_role("button", name="Twist").click()
    page.wait_for_function("[...document.querySelectorAll('input')].some((one) => one.value == '77.9')")
    assert page.get_by_text("Compiling the models").is_visible()  # The controls follow before the models are there.
    assert len(ends) == 1
    ends[0]()
    page.get_by_text("then cable 2 by").wait_for(timeout=3 * LONG)
    assert page.get_by_text("Compiling the models").count() == 0
    assert read_pulls(page) == pytest.approx(PULLS["Twist"], abs=0.1)


@pytest.mark.slow
def test_another_design_brings_its_own_cables(open_shape):
    one, page = open_shape()
    inner = next(iter(one._pages.values()))[0]
    inner.post(lambda: inner.set_design(presets.get("spirob-15")))
    page.get_by_text("Cable 3 [mm]").wait_for(state="detached", timeout=LONG)
    page.get_by_text("cable 2 (ventral)").wait_for(timeout=LONG)
    page.get_by_role("button", name="Ventral").click()
    page.get_by_text("Tension of cable 1: slack").wait_for(timeout=LONG)
    stroke = 1e3 * presets.get("spirob-15").cable_stroke
    assert read_pulls(page) == pytest.approx([-math.floor(stroke), 0.35 * stroke], abs=0.1)
