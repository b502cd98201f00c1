"""Settings of pages."""

import threading

from spiraltrunk.studio.page.store import MOST_LENGTH, MOST_PAGES, PageStore


def test_a_reload_finds_its_settings_once_the_old_page_is_gone():
    store = PageStore()
    assert store.enter("a", "b") == ("a", {})

    def leave():
        store.save("a", {"size": 3})
        store.leave("a")

    timer = threading.Timer(0.2, leave)
    timer.start()
    assert store.enter("a", "b", patience=30.0) == ("a", {"size": 3})
    timer.join()


def test_a_page_open_twice_is_two_pages():
    store = PageStore()
    store.enter("a", "b")
    store.save("a", {"size": 3})
    assert store.enter("a", "b", patience=0.0) == ("b", {"size": 3})


def test_what_is_kept_is_limited():
    store = PageStore()
    store.save("long", {"text": "x" * MOST_LENGTH})
    assert store.enter("long", "b") == ("long", {})
    for i in range(MOST_PAGES + 1):
        store.save(str(i), {"i": i})
    assert store.enter("0", "b") == ("0", {})
    assert store.enter("1", "b") == ("1", {"i": 1})
