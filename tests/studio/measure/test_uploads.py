"""Files of a person in a real browser: a C3D take is drawn; what is no take is told in one line, with what to do."""

import numpy as np
import pytest

from spiraltrunk.mocap import load_take
from spiraltrunk.studio.measure.tab import MeasureTab

pytestmark = pytest.mark.slow  # A real browser, which draws by software: minutes in all.

LONG = 60_000
"""Time in which a take is read on a busy machine [ms]."""


@pytest.fixture
def c3d(virtual):
    """The virtual take's markers as a C3D file."""
    ezc3d = pytest.importorskip("ezc3d", reason="ezc3d is not installed")
    take = load_take(virtual / "rest-045_1.csv", axes="y-up")
    content = ezc3d.c3d()
    content["parameters"]["POINT"]["RATE"]["value"] = [take.rate]
    content["parameters"]["POINT"]["UNITS"]["value"] = ["m"]
    content["parameters"]["POINT"]["LABELS"]["value"] = [marker.name for marker in take.markers]
    points = np.ones((4, len(take.markers), len(take.frame)))
    points[:3] = np.moveaxis([marker.position for marker in take.markers], -1, 0)
    content["data"]["points"] = points
    file = virtual.parent / "rest-045_1.c3d"
    content.write(str(file))
    return file.read_bytes()


@pytest.fixture
def send(studio, open_page):
    """Uploads: ``send(name, content)`` gives the page."""
    page = open_page(studio([MeasureTab]))
    page.get_by_text("No recording yet").wait_for()
    page.get_by_role("alert").get_by_role("button").first.click()  # That WebGL is drawn by software.
    page.get_by_role("alert").wait_for(state="detached")

    def start(name, content):
        file = {"name": name, "mimeType": "application/octet-stream", "buffer": content}
        page.locator("input[type=file]").first.set_input_files(file)
        return page

    return start


def read_notice(page):
    """Text of the notice below its title: one line that says what is allowed, names no path of ours, and is seen."""
    notice = page.get_by_role("alert").filter(has_text="Not accepted")
    notice.wait_for(timeout=LONG)
    text = notice.inner_text().split("\n")
    assert text[0] == "Not accepted"
    assert len(text) == 2
    assert "upload_" not in text[1]
    assert "allowed: " in text[1] or "choose its run: " in text[1]
    page.wait_for_timeout(800)  # It slides in.
    box = notice.bounding_box()
    assert box["x"] >= 0
    assert box["x"] + box["width"] <= 876
    assert box["y"] + box["height"] <= 800
    notice.get_by_role("button").click()
    notice.wait_for(state="detached")
    return text[1]


def test_a_c3d_take_is_drawn_over_the_model(send, take_picture, c3d):
    page = send("rest-045_1.c3d", c3d)
    page.get_by_text("mean RMSE").wait_for(timeout=LONG)
    page.get_by_text("rest-045_1.c3d").first.wait_for()
    page.wait_for_timeout(1000)
    take_picture(page, "c3d")
    page.get_by_role("alert").first.wait_for(state="detached", timeout=LONG)  # That of an error would stay.
    assert page.get_by_role("alert").all_inner_texts() == []


def test_damaged_and_foreign_files_are_told_one_by_one(send, virtual, c3d):
    whole = (virtual / "rest-045_1.csv").read_bytes()
    junk = np.random.default_rng(3).bytes(20_000)
    for name, content, word in (
        ("rest-045_1.c3d", junk, "C3D file"),
        ("rest-045_1.c3d", c3d[:1500], "C3D file"),
        ("rest-045_1.csv", junk, "rest-045_1.csv"),
        ("rest-045_1.csv", whole[:700], "rest-045_1.csv"),
        ("rest-045_1.csv", b"", "'rest-045_1.csv' is empty"),
        ("holiday.csv", b"", "'holiday.csv' is empty"),
        ("rest-045_1.exe", whole, "allowed: a Motive CSV, or C3D"),
        ("holiday.c3d", c3d, "choose its run"),
        ("../../etc/rest-045.exe", junk, "'rest-045.exe'"),
        ("rest-045_1.c3d", bytes(25_000_001), "allowed: at most 25 MB"),
    ):
        page = send(name, content)
        told = read_notice(page)
        print(name, len(content), told)
        assert word in told
        assert page.get_by_text("uploaded successfully").count() == 0
        page.get_by_text("No takes.").wait_for()
    page.get_by_text("Uploading").wait_for(state="detached", timeout=LONG)  # Nothing waits for what was refused.
    send("rest-045_1.csv", whole).get_by_text("mean RMSE").wait_for(timeout=LONG)


def test_a_bad_take_is_told_and_the_others_are_compared_without_it(send, virtual):
    whole = (virtual / "rest-045_1.csv").read_bytes()
    page = send("rest-045_1.csv", whole)
    page.get_by_text("mean RMSE").wait_for(timeout=LONG)
    send("rest-045_2.csv", whole[:700])
    notice = page.get_by_role("alert").filter(has_text="rest-045_2.csv")
    notice.wait_for(timeout=LONG)
    page.get_by_text("rest-045_2.csv as").wait_for(state="detached", timeout=LONG)
    page.get_by_text("No comparison").filter(visible=True).wait_for(state="detached", timeout=LONG)
    page.get_by_text("mean RMSE").wait_for(timeout=LONG)
    page.wait_for_timeout(5000)  # The others are compared by then,
    notice.wait_for(timeout=LONG)  # and the notice is still there, or there again.
    assert page.get_by_text("mean RMSE").is_visible()
