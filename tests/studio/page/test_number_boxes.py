"""Number boxes in a real browser: one that is left without a number shows the value that holds."""

import pytest

pytest.importorskip("viser", reason="viser is not installed")

from spiraltrunk.studio.page.controls import Scale, Slider

pytestmark = pytest.mark.slow  # A real browser, which draws by software.

SCALE = Scale(label="Ratio m", unit="", least=0.2, most=10.0, step=0.001, hint="A ratio")


class BoxTab:
    """A tab with one slider, which keeps the values that it takes."""

    name, title = "box", "Box"
    taken = []  # noqa: RUF012

    def __init__(self, page):
        self.page = page

    def build(self):
        BoxTab.taken.clear()
        Slider(self.page, SCALE, 1.531, self.taken.append)

    def show(self):
        pass

    hide = close = show

    def read_settings(self):
        return {}

    def apply_settings(self, settings):
        pass


def test_a_box_left_without_a_number_goes_back(studio, open_page):
    page = open_page(studio([BoxTab]))
    box = page.locator("input[inputmode]").filter(visible=True).first
    box.wait_for()
    for text in ("", "-"):
        box.fill(text)
        assert box.input_value() == text
        box.press("Tab")
        page.wait_for_timeout(1000)
        assert box.input_value() == "1.531"
    assert BoxTab.taken == []
    box.fill("2.5")
    box.press("Tab")
    page.wait_for_timeout(1500)
    assert (box.input_value(), BoxTab.taken) == ("2.5", [2.5])
    box.fill("")
    box.press("Tab")
    page.wait_for_timeout(1000)
    assert (box.input_value(), BoxTab.taken) == ("2.5", [2.5])
