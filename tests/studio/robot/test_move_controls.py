"""Jogs of the Robot tab, without a browser: each is that of its click, or none."""

from types import SimpleNamespace
from unittest.mock import MagicMock

import pytest

pytest.importorskip("viser", reason="viser is not installed")

from spiraltrunk.design import presets
from spiraltrunk.studio.page.page import Page
from spiraltrunk.studio.robot import move_controls
from spiraltrunk.studio.robot.move_controls import MoveControls


@pytest.fixture
def desk(monkeypatch):
    """Buttons of cable 1 and the step's handle, with acts that wait until they are run, at a time that is set."""
    acts, asked, told = [], [], []
    page = MagicMock()
    page.post.side_effect = acts.append
    page.post_taken = lambda key, act: Page.post_taken(page, key, act)
    page._try_taking = lambda key, act: Page._try_taking(page, key, act)
    page.notice.side_effect = lambda text, kind="error", *_, **__: told.append((kind, text))
    rows = [MagicMock() for _ in range(3)]
    page.gui.add_button_group.side_effect = rows.copy()
    clock = SimpleNamespace(now=0.0)
    monkeypatch.setattr(move_controls, "time", SimpleNamespace(monotonic=lambda: clock.now))
    controls = MoveControls(page, presets.PAPER, asked.append)
    step, click = controls.step.handle, rows[0].on_click.call_args.args[0]

    def press(way):
        rows[0].value = way
        click(None)

    def run():
        while acts:
            acts.pop(0)()

    step.value = 5.0
    return SimpleNamespace(press=press, run=run, step=step, clock=clock, asked=asked, told=told, row=rows[0])


def test_a_jog_has_the_way_and_the_step_of_its_click(desk):
    desk.press("wind in")
    desk.row.value, desk.step.value = "let out", 20.0
    desk.run()
    assert [(jog.cable, jog.way) for jog in desk.asked] == [(0, pytest.approx(5e-3))]


def test_a_click_that_has_waited_moves_nothing(desk):
    desk.press("wind in")
    desk.clock.now = 0.51
    desk.press("let out")
    desk.run()
    assert [jog.way for jog in desk.asked] == [pytest.approx(-5e-3)]
    assert desk.told == [
        ("refusal", "cable 1 was not moved: the click waited 0.51 s; allowed: at most 0.5 s; press again"),
    ]


@pytest.mark.parametrize(("way", "step"), [("sideways", 5.0), ("wind in", 500.0), ("wind in", "x")])
def test_what_the_controls_do_not_offer_is_refused(desk, way, step):
    desk.step.value = step
    desk.press(way)
    desk.run()
    assert not desk.asked
    assert [kind for kind, _ in desk.told] == ["refusal"]
