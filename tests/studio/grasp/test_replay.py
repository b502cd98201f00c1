"""A replay is one file that plays without a server and a network."""

from __future__ import annotations

import numpy as np
import pytest

from spiraltrunk.studio.grasp.replay import format_replay, write_replay

from .conftest import build_recording


@pytest.mark.slow
def test_it_opens_offline_and_its_picture_changes_while_it_plays(
    recording, open_context, tmp_path, take_picture, capsys
):
    file = tmp_path / "replay.html"
    write_replay(recording, file)
    assert capsys.readouterr().out == "", "viser prints nothing"
    page, asked, faults = open_context(offline=True).new_page(), [], []
    page.on("request", lambda request: asked.append(request.url))
    page.on("pageerror", lambda error: faults.append(str(error)))
    page.goto(file.as_uri())
    assert page.title() == recording.title
    box = page.locator(".mantine-NumberInput-wrapper").first
    assert box.evaluate("box => getComputedStyle(box, '::after').content") == '"s"'
    seen = []
    for i in range(40):
        page.wait_for_timeout(250)
        seen.append(take_picture(page, f"replay_{i}"))
        if sum(_differ(one, seen[-1]) for one in seen[:-1]) >= 2:
            break
    else:
        raise AssertionError("the picture does not change")
    early, late = (_scrub(page, take_picture, text) for text in ("0.2", "2.8"))
    assert _differ(early, late)
    assert not faults
    assert [url for url in asked if not url.startswith(("file:", "data:", "blob:"))] == []


def _scrub(page, take_picture, text):
    """The picture at a time, where it stays."""
    box = page.get_by_role("textbox").first
    box.fill(text)
    box.press("Enter")
    last = None
    for _ in range(40):
        page.wait_for_timeout(250)
        now = take_picture(page, f"scrubbed_{text}")
        if last is not None and np.array_equal(now, last):
            return now
        last = now
    raise AssertionError("it goes on playing")


def _differ(one, other):
    return (np.abs(one - other).max(axis=2) > 30).mean() > 0.002


def test_the_title_is_text_and_no_markup(recording):
    page = format_replay(build_recording(1, "<script>alert(1)</script>"))
    assert "<title>&lt;script&gt;alert(1)&lt;/script&gt;</title>" in page
    assert "<script>alert(1)" not in page


def test_no_address_is_left_in_it(recording):
    page = format_replay(recording)
    assert "127.0.0.1" not in page
    assert "ws://" not in page.split("__VISER_EMBED_DATA__")[-1]
