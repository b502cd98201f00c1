"""Acts of a page that wait for a while."""

import threading
from types import SimpleNamespace

import pytest

pytest.importorskip("viser", reason="viser is not installed")

from spiraltrunk.design import presets
from spiraltrunk.studio.page.page import Page

LONG = 30.0
"""Longest wait for a thread of a busy computer [s]."""


@pytest.fixture
def page():
    one = Page(SimpleNamespace(gui=None, scene=None), presets.PAPER)
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
