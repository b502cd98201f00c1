"""Acts of a page that wait for a while."""

import threading
from types import SimpleNamespace

import pytest

pytest.importorskip("viser", reason="viser is not installed")

from spiraltrunk.design import presets
from spiraltrunk.errors import DriveError, OutputError, StudioError
from spiraltrunk.studio.page.job import Refusal
from spiraltrunk.studio.page.page import MOST_ERRORS, Page


class FakeClient(SimpleNamespace):
    """A client of viser that keeps which notices are shown, and for how long [s]."""

    def __init__(self):
        super().__init__(gui=None, scene=None, shown={})

    def add_notification(self, title, text, *, color, auto_close_seconds):
        self.shown[text] = auto_close_seconds
        return SimpleNamespace(remove=lambda: self.shown.pop(text))


LONG = 30.0
"""Longest wait for a thread of a busy computer [s]."""


@pytest.fixture
def page():
    one = Page(FakeClient(), presets.PAPER)
    yield one
    one.close()


def run_to(page, seconds=0.0):
    """Wait until an act has run that comes after ``seconds``."""
    ended = threading.Event()
    page.later("end", ended.set, seconds)
    assert ended.wait(LONG)


def test_timers_that_have_fired_are_forgotten(page):
    seen = []
    for i in range(50):
        page.later(f"slider {i}", lambda i=i: seen.append(i), 0.01)
    page.later("waits", seen.clear, LONG)
    while len(seen) < 50:
        run_to(page, 0.01)
    assert sorted(seen) == list(range(50))
    assert set(page._timers) == {"waits"}
    page.close()
    assert page._timers == {}


def test_of_acts_under_one_key_the_last_runs_after_a_new_wait(page):
    seen = []
    for name in "abc":
        page.later("slider", lambda name=name: seen.append(name), 0.2)
    assert seen == []
    while not seen:
        run_to(page, 0.01)
    run_to(page, 0.3)
    assert seen == ["c"]


def test_an_act_replaced_at_the_moment_it_fires_does_not_run(page):
    seen = []
    page.later("slider", lambda: seen.append("old"), 0.05)
    fired = page._timers["slider"]
    with page._lock:
        fired.join(0.2)  # Its time has come, and it waits for the lock.
        del page._timers["slider"]
    fired.join(LONG)
    run_to(page)
    assert seen == []


def test_a_closed_page_starts_no_timer(page):
    seen = []
    page.close()
    page.later("slider", lambda: seen.append(1), 0.01)
    assert page._timers == {}
    assert seen == []


def run_act(page, error=None, key="act"):
    def act():
        if error is not None:
            raise error

    page.take(key, act)
    run_to(page)


def test_one_refusal_at_a_time_is_shown_and_errors_stay(page):
    run_act(page, StudioError("the first"))
    assert page.client.shown == {"the first": 8.0}
    run_act(page, StudioError("the second"))
    assert page.client.shown == {"the second": 8.0}
    run_act(page, OutputError("the disc is full"), "save")
    run_act(page, DriveError("no bus"))
    kept = {"the disc is full": None, "no bus": None}
    assert page.client.shown == {"the second": 8.0, **kept}
    page.clear_refusal()
    page.clear_refusal()
    assert page.client.shown == kept
    page.post(fail_at_work)
    run_to(page)
    assert page.client.shown == {**kept, "the work failed": None}


def test_an_error_is_replaced_by_the_next_of_its_act_and_ends_with_its_success(page):
    run_act(page, DriveError("no bus"))
    run_act(page, OutputError("the disc is full"), "save")
    run_act(page, DriveError("no board"))
    assert page.client.shown == {"the disc is full": None, "no board": None}
    run_act(page)
    assert page.client.shown == {"the disc is full": None}


def test_the_oldest_of_many_errors_goes(page):
    for i in range(MOST_ERRORS + 2):
        page.notice(f"error {i}", topic=str(i))
    assert page.client.shown == {f"error {i}": None for i in range(2, MOST_ERRORS + 2)}


def test_work_that_refuses_what_it_was_given_is_told_as_a_refusal(page):
    page.tell_failure(Refusal("the file is empty"), "work")
    page.tell_failure("its process ended", "work")
    assert page.client.shown == {"the file is empty": 8.0, "its process ended": None}


def fail_at_work():
    raise StudioError("the work failed")


def test_who_listens_for_a_dark_ground_is_told_the_present_one_and_each_change(page):
    page.set_dark(True)
    told = []
    page.on_dark(told.append)
    page.set_dark(False)
    page.set_dark(True)
    assert told == [True, False, True]
