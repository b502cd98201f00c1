"""Number boxes in a real browser: what is typed is taken when it is complete, or refused in words."""

import pytest

pytest.importorskip("viser", reason="viser is not installed")

from spiraltrunk.studio.page.controls import Slider
from spiraltrunk.studio.page.scale import Scale

pytestmark = pytest.mark.slow  # A real browser, which draws by software.

SCALE = Scale(label="Angle", unit="mm", least=0.2, most=90.0, step=0.5, digits=3, hint="A measure")
COUNT = Scale(label="Number", unit="", least=1, most=300, step=1, hint="A count")

REST = 1200
"""Time after which a change that was sent has come back [ms]."""


class BoxTab:
    """A tab with two sliders, which keeps the values that they take."""

    name, title = "box", "Box"
    taken = []  # noqa: RUF012
    counted = []  # noqa: RUF012

    def __init__(self, page):
        self.page = page

    def build(self):
        BoxTab.taken.clear()
        BoxTab.counted.clear()
        BoxTab.slider = Slider(self.page, SCALE, 1.531, self.taken.append)
        Slider(self.page, COUNT, 18, self.counted.append)

    def show(self):
        pass

    hide = close = show

    def read_settings(self):
        return {}

    def apply_settings(self, settings):
        pass


@pytest.fixture
def opened(studio, open_page):
    """A page, and its boxes of a measure and of a count."""
    page = open_page(studio([BoxTab]))
    boxes = page.locator("input[inputmode]").filter(visible=True)
    boxes.nth(1).wait_for()
    return page, boxes.nth(0), boxes.nth(1)


def type_text(box, text):
    """Type key by key, as fast as it goes, in the place of what stands there."""
    box.click()
    box.press("Control+A")
    box.press_sequentially(text)


@pytest.mark.parametrize("key", ["Enter", "Tab"])
def test_only_the_complete_number_is_taken(opened, key):
    page, box, count = opened
    for one, text, value, taken in (
        (box, "40", 40.0, BoxTab.taken), (box, "1e1", 10.0, BoxTab.taken), (box, "0.0004e4", 4.0, BoxTab.taken),
        (box, "2.71828", 2.718, BoxTab.taken), (count, "1e2", 100.0, BoxTab.counted),
        (count, "17.6", 18.0, BoxTab.counted),
    ):  # fmt: skip
        type_text(one, text)
        page.wait_for_timeout(300)
        assert one.input_value() == text
        assert value not in taken, "nothing is sent before it is complete"
        one.press(key)
        page.wait_for_timeout(REST)
        assert (float(one.input_value()), taken[-1]) == (value, value)
    assert BoxTab.taken[:3] == [40.0, 10.0, 4.0]
    assert page.get_by_role("alert").filter(has_text="allowed").count() == 0


@pytest.mark.parametrize("key", ["Enter", "Tab"])
def test_what_is_no_value_is_told_once_and_the_box_goes_back(opened, key):
    page, box, _ = opened
    told = page.get_by_role("alert").filter(has_text="allowed")
    number = "Angle was '{}'; allowed: a number, 0.2 to 90 mm, with a point for decimals"
    for text, words in (
        ("400", "Angle was 400; allowed: 0.2 to 90 mm"), ("-3", "Angle was -3; allowed: 0.2 to 90 mm"),
        ("1_0", number.format("1_0")), ("\u0662", number.format("\u0662")),
        ("2,5", number.format("2,5")), ("-", number.format("-")), ("12abc", number.format("12abc")),
    ):  # fmt: skip
        type_text(box, text)
        box.press(key)
        told.filter(has_text=words).wait_for()
        assert box.input_value() == "1.531"
        page.wait_for_timeout(REST)
        assert told.all_inner_texts() == [f"Not accepted\n{words}"], "it takes the place of the last one"
        assert box.input_value() == "1.531"
    assert BoxTab.taken == []
    type_text(box, "2.5")
    box.press(key)
    page.wait_for_timeout(REST)
    assert (box.input_value(), BoxTab.taken) == ("2.5", [2.5])
    assert told.count() == 0, "a good value ends it"


def test_a_number_that_the_box_rounds_is_told(opened):
    page, box, count = opened
    for one, text, words in (
        (count, "2.5", "Number: 2.5 \u2192 3"), (box, "2.71828", "Angle: 2.71828 \u2192 2.718 mm"),
    ):  # fmt: skip
        type_text(one, text)
        one.press("Enter")
        page.get_by_role("alert").filter(has_text=words).wait_for()
        assert page.get_by_role("alert").filter(has_text="Adjusted").all_inner_texts() == [f"Adjusted\n{words}"]
    type_text(box, "4")
    box.press("Enter")
    page.get_by_role("alert").filter(has_text="Adjusted").wait_for(state="detached", timeout=5000)


def test_escape_or_an_emptied_box_gives_the_value_before(opened):
    page, box, _ = opened
    type_text(box, "44")
    box.press("Escape")
    assert box.input_value() == "1.531"
    box.press("Tab")
    type_text(box, "")
    box.press("Delete")
    assert box.input_value() == ""
    box.press("Tab")
    page.wait_for_timeout(REST)
    assert box.input_value() == "1.531"
    assert BoxTab.taken == []
    assert page.get_by_role("alert").filter(has_text="allowed").count() == 0


def test_arrows_act_at_once_and_take_first_what_was_typed(opened):
    page, box, count = opened
    box.click()
    box.press("ArrowUp")
    page.wait_for_timeout(REST)
    assert BoxTab.taken == [2.031]
    type_text(box, "40")
    box.press("ArrowDown")
    page.wait_for_timeout(REST)
    assert (box.input_value(), BoxTab.taken[-1]) == ("39.5", 39.5)
    type_text(count, "299")
    for _ in range(3):
        count.press("ArrowUp")
    page.wait_for_timeout(REST)
    assert (count.input_value(), BoxTab.counted[-1]) == ("300", 300.0)
    slider = page.get_by_role("slider").first
    slider.focus()
    slider.press("ArrowRight")
    page.wait_for_timeout(REST)
    assert BoxTab.taken[-1] == 40.0


def test_the_server_does_not_write_into_a_box_that_is_typed_in(opened):
    page, box, _ = opened
    type_text(box, "3")
    BoxTab.slider.set(7.0)
    page.wait_for_timeout(REST)
    assert box.input_value() == "3"
    box.press_sequentially("3")
    box.press("Enter")
    page.wait_for_timeout(REST)
    assert (box.input_value(), BoxTab.taken) == ("33", [33.0])
    type_text(box, "4")
    BoxTab.slider.set(7.0)
    page.wait_for_timeout(2 * REST)
    box.press("Escape")
    assert box.input_value() == "7"


def test_a_box_that_is_gone_is_not_written_into(opened, caplog):
    page, box, _ = opened
    type_text(box, "3")
    box.press("Enter")
    page.wait_for_timeout(300)
    BoxTab.slider.set(7.0)  # Written once the person rests.
    BoxTab.slider.handle.remove()
    page.wait_for_timeout(REST)
    assert page.get_by_role("alert").filter(has_text="An error in the studio").count() == 0
    assert BoxTab.taken == [3.0]
    assert caplog.records == []
