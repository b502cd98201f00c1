"""Files that are dropped onto a page, in a real browser."""

import time

import pytest

pytest.importorskip("viser", reason="viser is not installed")

from spiraltrunk.studio.page.buttons import add_upload

TAKEN = []

DROP = """(files) => {
  const given = new DataTransfer();
  for (const [name, text] of files) given.items.add(new File([text], name));
  const event = (kind) => new DragEvent(kind, { dataTransfer: given, bubbles: true, cancelable: true });
  const isOver = !document.querySelector("canvas").dispatchEvent(event("dragover"));
  return [isOver, !document.querySelector("canvas").dispatchEvent(event("drop"))];
}"""


class FileTab:
    """A tab that takes one kind of file."""

    def __init__(self, page, title, kinds):
        self.page, self.name, self.title, self.kinds = page, title.lower(), title, kinds

    def build(self):
        take = lambda name, content: TAKEN.append((self.title, name, content))  # noqa: E731
        add_upload(self.page, f"Give {self.title}", take, hint="Takes a file", most=100, kinds=self.kinds)

    def show(self):
        pass

    hide = close = show

    def read_settings(self):
        return {}

    def apply_settings(self, settings):
        pass


def wait_for_taken(count):
    end = time.monotonic() + 60.0
    while len(TAKEN) < count and time.monotonic() < end:
        time.sleep(0.05)
    return TAKEN


@pytest.mark.slow
def test_a_dropped_file_goes_to_the_button_of_the_shown_tab_that_takes_it(studio, open_page):
    TAKEN.clear()
    kinds = (("Mesh", ".stl,.obj"), ("Take", ".csv"))
    page = open_page(studio([lambda page, one=one: FileTab(page, *one) for one in kinds]))
    page.get_by_role("button", name="Give Mesh").wait_for()
    page.wait_for_function("window.spiraltrunkDrop === true")
    assert page.evaluate(DROP, [["../a/Ball.STL", "solid"]]) == [True, True]
    assert wait_for_taken(1) == [("Mesh", "Ball.STL", b"solid")]
    assert page.evaluate(DROP, [["take.csv", "x"]]) == [True, True]
    page.get_by_text("take.csv has no place here; the tab Measure takes it").wait_for()
    assert page.evaluate(DROP, [["take.txt", "x"]]) == [True, True]
    page.get_by_text("take.txt has no place here; allowed: .stl, .obj").wait_for()
    page.evaluate(DROP, [["a.stl", "x"], ["b.stl", "y"]])
    page.get_by_text("2 files were dropped; allowed: one at a time").wait_for()
    page.get_by_role("button", name="Take", exact=True).click()
    page.get_by_role("button", name="Give Take").wait_for()
    page.evaluate(DROP, [["take.csv", "x"]])
    assert wait_for_taken(2)[1:] == [("Take", "take.csv", b"x")]
    assert page.get_by_role("button", name="Take", pressed=True).count() == 1, "the page itself stays"
