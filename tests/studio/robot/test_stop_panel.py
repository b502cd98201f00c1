"""STOP in a real browser: nothing that a person does to the page hides it."""

import time

import pytest

pytest.importorskip("viser", reason="viser is not installed")

from spiraltrunk.studio.robot.stop_panel import StopPanel

pytestmark = pytest.mark.slow  # A real browser, which draws by software.

CONTROLS = "[data-dock-minimize], [data-dock-minimize-all], [data-dock-griphandle]"
"""What minimises a window of viser, by a click."""

HELD = """() => {
  const isStop = (one) => one.checkVisibility() && /STOP/.test(one.innerText);
  const one = [...document.querySelectorAll("button")].find(isStop);
  const box = one?.getBoundingClientRect();
  return Boolean(box) && one.contains(document.elementFromPoint(box.x + box.width / 2, box.y + box.height / 2));
}"""
"""Whether STOP is in the page and nothing lies over it."""

SIZE, NARROW = {"width": 1280, "height": 800}, {"width": 420, "height": 800}


class StopTab:
    """A tab with STOP, which counts what is pressed."""

    name, title, pressed = "stop", "Robot", 0

    def __init__(self, page):
        self.page = page

    def build(self):
        StopTab.pressed = 0
        self.panel = StopPanel(self.page, self.count)
        self.panel.show(True)

    def count(self):
        StopTab.pressed += 1

    def show(self):
        pass

    hide = close = show

    def read_settings(self):
        return {}

    def apply_settings(self, settings):
        pass


def press(page):
    before = StopTab.pressed
    page.get_by_role("button", name="STOP").click()
    end = time.monotonic() + 60.0
    while StopTab.pressed == before and time.monotonic() < end:
        page.wait_for_timeout(50)
    assert StopTab.pressed > before


def test_stop_stays_over_the_page(studio, open_page):
    one = studio([StopTab])
    page = open_page(one)
    page.get_by_role("button", name="STOP").wait_for()
    for control in page.locator(CONTROLS).filter(visible=True).all():
        control.click()
        page.wait_for_timeout(1000)
        assert page.evaluate(HELD)
    press(page)
    page.set_viewport_size(NARROW)
    page.wait_for_timeout(1000)
    assert page.evaluate(HELD)
    press(page)
    page.set_viewport_size(SIZE)
    page.evaluate("document.getElementById('spiraltrunk-stop').remove()")
    page.wait_for_timeout(1000)
    press(page)
    page.keyboard.press("Control+K")
    page.get_by_placeholder("Search commands").wait_for()
    page.wait_for_timeout(500)
    assert page.evaluate(HELD)
    one.stop()
    page.get_by_role("button", name="STOP: no connection").wait_for()


def test_the_window_of_viser_is_not_needed(studio, open_page):
    page = open_page(studio([StopTab]))
    page.get_by_role("button", name="STOP").wait_for()
    page.evaluate("window.spiraltrunkStop.id = 'none'")  # As in the narrow layout before its window was opened.
    page.wait_for_timeout(500)
    assert page.evaluate(HELD)
    stop = page.locator("#spiraltrunk-stop")
    assert (stop.inner_text(), stop.get_attribute("data-lost")) == ("STOP (Esc)", "false")
    press(page)
    page.wait_for_timeout(500)
    assert StopTab.pressed == 1, "one click stops once"
    assert page.evaluate(HELD)
    page.keyboard.press("Escape")
    page.wait_for_timeout(1000)
    assert StopTab.pressed >= 2
