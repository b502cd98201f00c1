"""Tabs are imported when they are built, and have the titles by which the bar shows them before."""

import subprocess
import sys

import pytest

pytest.importorskip("viser", reason="viser is not installed")

from spiraltrunk.studio.page.later_tab import LaterTab
from spiraltrunk.studio.tabs import TABS, build_tabs


def fail():
    raise AssertionError("a robot was opened before its tab was built")


def find_class(load):
    found = load()
    return getattr(found, "func", found)


def test_titles_and_names_are_those_of_the_tabs():
    later = [kind for kind in build_tabs(lambda: None) if getattr(kind, "func", None) is LaterTab]
    assert len(later) == 4
    for kind in later:
        tab, own = kind(None), find_class(kind.keywords["load"])
        assert (tab.title, tab.name) == (own.title, own.name)


def test_no_robot_is_opened_with_the_page():
    assert [kind(None).title for kind in build_tabs(fail) if kind not in TABS] == ["Robot"]


def test_only_the_first_tab_is_imported_with_the_others_titles():
    code = "import sys, spiraltrunk.studio.tabs; print(*(one for one in sys.modules if one.endswith('.tab')))"
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert set(found.stdout.split()) == {"spiraltrunk.studio.grasp.tab", "spiraltrunk.studio.page.tab"}


def test_calls_go_to_the_tab_that_was_loaded():
    class One:
        def __init__(self, page):
            self.seen = [page]

        def __getattr__(self, name):
            return lambda *arguments: self.seen.append((name, *arguments)) or {"n": len(self.seen)}

    tab = LaterTab("page", title="One", load=lambda: One)
    tab.build()
    tab.show()
    tab.hide()
    assert tab.read_settings() == {"n": 5}
    tab.apply_settings({"n": 1})
    tab.close()
    names = ["build", "show", "hide", "read_settings"]
    assert tab.tab.seen == ["page", *((name,) for name in names), ("apply_settings", {"n": 1}), ("close",)]
