"""Every control of every tab says in one line what it does, has a name, and can be used by keyboard alone."""

from functools import partial

import pytest

pytest.importorskip("viser", reason="viser is not installed")

from spiraltrunk.design import presets
from spiraltrunk.studio.robot import hub as hub_module
from spiraltrunk.studio.robot.hub import RobotHub
from spiraltrunk.studio.robot.tab import RobotTab
from spiraltrunk.studio.tabs import TABS
from spiraltrunk.workflows.drive.remote.requests import Stop

pytestmark = pytest.mark.slow  # A real browser, which draws by software: minutes in all.

LONG = 120_000
"""Time in which all tabs are built on a busy machine [ms]."""

TITLES = ("Design", "Shape", "Grasp", "Measure", "Robot")

LONGEST = 220
"""Most characters of an explanation [-] (ours: some lines of the note beside the pointer)."""

FOCUSED = """() => {
  const one = document.activeElement, where = one.closest("label")?.innerText ?? "";
  const kind = one.getAttribute("role") ?? one.tagName.toLowerCase();
  return [kind, one.getAttribute("aria-label") || one.innerText || one.labels?.[0]?.innerText || where];
}"""

CONTRASTS = """() => {
  const read = (color) => {
    const parts = color.match(/[\\d.]+/g).map(Number);
    return color.startsWith("color(") ? [...parts.slice(0, 3).map((one) => 255 * one), parts[3] ?? 1]
      : [...parts.slice(0, 3), parts[3] ?? 1];
  };
  const mix = (below, above, share) => below.map((one, i) => one + share * (above[i] - one));
  const light = (color) => {
    const [r, g, b] = color.map((one) => one / 255 <= 0.04045 ? one / 3294.6 : ((one / 255 + 0.055) / 1.055) ** 2.4);
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
  };
  const found = [], walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  while (walker.nextNode()) {
    const text = walker.currentNode.textContent.trim(), one = walker.currentNode.parentElement;
    const box = one.getBoundingClientRect();
    const isSeen = one.checkVisibility({ opacityProperty: true, visibilityProperty: true });
    if (!text || !isSeen || box.width < 2 || box.height < 2 || ["STYLE", "SCRIPT"].includes(one.tagName)) continue;
    const grounds = [];
    let opacity = 1;
    for (let part = one; part; part = part.parentElement) {
      const style = getComputedStyle(part);
      opacity *= Number(style.opacity);
      grounds.unshift(read(style.backgroundColor));
      if (grounds[0][3] === 1) break;
    }
    const ground = grounds.reduce((below, above) => mix(below, above, above[3]), [255, 255, 255]);
    const letters = read(getComputedStyle(one).color);
    const [low, high] = [light(mix(ground, letters, opacity * letters[3])), light(ground)].sort((a, b) => a - b);
    found.push([text.slice(0, 60), (high + 0.05) / (low + 0.05)]);
  }
  return found;
}"""
"""Each text that is seen, and its contrast to its ground, 1 to 21 (Web Content Accessibility Guidelines 2.1)."""


class FakeLink:
    """A link to a robot of which nothing is known, that keeps what it is asked."""

    def __init__(self, setup, *, on_state, on_refusal, on_end):
        self.setup, self.asked, self._on_end = setup, [], on_end

    def start(self):
        pass

    def ask(self, request, asker=""):
        self.asked.append(request)

    def close(self):
        self._on_end(None)

    def join(self):
        pass


@pytest.fixture
def hub(monkeypatch):
    monkeypatch.setattr(hub_module, "RobotLink", FakeLink)
    one = RobotHub(presets.PAPER)
    yield one
    one.close()


@pytest.fixture
def opened(studio, open_page, hub):
    """A page with all tabs, the server's side of it, and its robot."""
    one = studio((*TABS, partial(RobotTab, hub=hub)), first="Design")
    page = open_page(one)
    page.set_default_timeout(LONG)
    for title in TITLES:
        show(page, title)
    page.wait_for_timeout(1000)
    (client, _), *_ = one._pages.values()
    return page, client.client, hub


def show(page, title):
    page.get_by_role("button", name=title, exact=True).click()
    page.get_by_role("button", name=title, exact=True, pressed=True).wait_for()
    page.wait_for_timeout(800)


def walk(page, most=120):
    """Kinds and names of all that the key Tab leads to, once around, from the top of the page."""
    seen = []
    for _ in range(2 * most):
        page.keyboard.press("Tab")
        seen.append(tuple(part.strip() for part in page.evaluate(FOCUSED)))
        if sum(kind == "body" for kind, _ in seen) == 2:
            break
    first, last = (i for i, (kind, _) in enumerate(seen) if kind == "body")  # The key starts where was clicked last.
    return seen[first + 1 : last]


def focus(page, name, most=120):
    """Go to a control by the key Tab."""
    for _ in range(most):
        page.keyboard.press("Tab")
        if " ".join(page.evaluate(FOCUSED)[1].split()) == name:
            return
    raise AssertionError(f"Tab does not lead to {name}")


def test_each_control_explains_itself_in_one_line(opened):
    _, client, _ = opened
    handles = client.gui._gui_input_handle_from_uuid.values()
    hints = {(getattr(one._impl.props, "label", "") or "", getattr(one._impl.props, "hint", None)) for one in handles}
    hints = {(label, hint) for label, hint in hints if hint is not None or label}
    assert len(hints) > 60
    missing = sorted(label for label, hint in hints if not hint)
    assert missing == []
    assert [(label, hint) for label, hint in hints if "\n" in hint or len(hint) > LONGEST] == []


def test_tab_leads_to_all_controls_and_each_has_a_name(opened):
    page, *_ = opened
    for title, least in (("Design", 30), ("Shape", 22), ("Grasp", 17), ("Measure", 18), ("Robot", 13)):
        show(page, title)
        seen = walk(page)
        kinds = [kind for kind, _ in seen]
        assert {"button", "slider"} <= set(kinds) or title in ("Grasp", "Measure", "Robot")
        named = [name for kind, name in seen if kind in ("slider", "combobox", "tab") or (kind == "input" and name)]
        assert "" not in named
        assert len([name for _, name in seen if name]) >= least, title
        assert {*TITLES} <= {name for _, name in seen}
        assert ("STOP (Esc)" in {name for _, name in seen}) == (title == "Robot")
        boxes = page.locator("input[inputmode]").filter(visible=True)
        assert all(boxes.nth(i).get_attribute("aria-label") for i in range(boxes.count()))


def test_all_letters_are_readable_in_light_and_dark(opened):
    page, *_ = opened
    for is_dark in (False, True):
        for title in TITLES:
            show(page, title)
            page.get_by_role("checkbox", name="Dark").set_checked(is_dark)
            page.wait_for_timeout(800)
            found = page.evaluate(CONTRASTS)
            assert {"spiraltrunk studio", title} <= {text for text, _ in found}
            assert [(text, contrast) for text, contrast in found if contrast < 4.5] == []


def test_folders_open_by_keyboard(opened):
    page, *_ = opened
    show(page, "Grasp")
    page.evaluate("document.activeElement.blur()")
    friction = page.get_by_role("slider", name="Friction")
    assert friction.filter(visible=True).count() == 0
    focus(page, "Options (folder)")
    page.keyboard.press("Enter")
    friction.first.wait_for()
    page.get_by_role("button", name="Options (folder)", expanded=True).wait_for()
    page.keyboard.press(" ")
    friction.first.wait_for(state="hidden")
    page.get_by_role("button", name="Options (folder)", expanded=False).wait_for()


def test_a_folder_is_found_as_it_was_left(opened):
    page, *_ = opened
    show(page, "Grasp")
    options = page.get_by_role("button", name="Options (folder)")
    options.click()
    page.get_by_role("button", name="Options (folder)", expanded=True).wait_for()
    show(page, "Shape")
    show(page, "Grasp")
    page.get_by_role("button", name="Options (folder)", expanded=True).wait_for()
    page.reload()
    page.get_by_role("button", name="Options (folder)", expanded=True).wait_for()
    options.click()
    page.get_by_role("button", name="Options (folder)", expanded=False).wait_for()
    show(page, "Shape")
    show(page, "Grasp")
    page.wait_for_timeout(1000)
    assert page.get_by_role("button", name="Options (folder)", expanded=False).count() == 1


def test_buttons_that_show_an_icon_alone_have_a_name(opened):
    page, *_ = opened
    page.wait_for_timeout(1000)
    nameless = """() => [...document.querySelectorAll("button")].filter((one) => one.checkVisibility()
      && !one.innerText.trim() && !one.getAttribute("aria-label")).map((one) => one.outerHTML.slice(0, 300))"""
    assert page.evaluate(nameless) == []


def test_the_large_stop_by_keyboard(opened):
    page, _, hub = opened
    show(page, "Robot")
    focus(page, "Connect")
    page.keyboard.press("Enter")
    page.get_by_text("CONNECTING").wait_for()
    asked = hub._link.asked
    show(page, "Design")  # It stays in view.
    button = page.get_by_role("button", name="STOP").bounding_box()
    assert button["height"] >= 60
    assert button["width"] >= 180
    weight = "one => getComputedStyle(one).fontWeight"
    assert int(page.get_by_text("STOP", exact=False).filter(visible=True).last.evaluate(weight)) >= 700
    for key in ("Enter", " ", "Escape"):
        asked.clear()
        if key == "Escape":
            page.get_by_role("textbox").filter(visible=True).first.focus()
        else:
            focus(page, "STOP (Esc)")
        page.keyboard.press(key)
        for _ in range(100):
            if Stop() in asked:
                break
            page.wait_for_timeout(100)
        assert Stop() in asked, key


def test_keys_of_tabs_and_commands_hold_where_a_box_has_the_focus(opened):
    page, *_ = opened
    for kind, key, title in (("Ratio m", "Alt+3", "Grasp"), ("Preset", "Alt+2", "Shape")):
        show(page, "Design")
        boxes = page.locator("input").filter(visible=True)
        if kind == "Preset":
            boxes.first.click()
            page.keyboard.press("Escape")
        else:
            page.locator("input[aria-label='Ratio m']").filter(visible=True).first.focus()
        assert page.evaluate("document.activeElement.tagName") == "INPUT"
        page.keyboard.press(key)
        page.get_by_role("button", name=title, exact=True, pressed=True).wait_for()
    show(page, "Design")
    boxes.first.focus()
    page.keyboard.press("Control+K")
    page.get_by_placeholder("Search").or_(page.get_by_text("Show Shape")).first.wait_for()
