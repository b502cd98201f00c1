"""The tab by real clicks and keys; the simulation is replaced but in the last test."""

from __future__ import annotations

import json
import os
from pathlib import Path

import numpy as np
import pytest
import trimesh

from spiraltrunk.errors import ModelError
from spiraltrunk.studio.grasp.tab import GraspTab
from spiraltrunk.workflows.grasp.recording import RATE

pytestmark = pytest.mark.slow  # A real browser, which draws by software: minutes in all.

PATIENCE = 60_000
"""Time within which the page reacts [ms]."""


def wait_for(page, text, **options):
    page.get_by_text(text).filter(visible=True).first.wait_for(timeout=options.pop("timeout", PATIENCE), **options)


def click(page, name):
    page.get_by_role("button", name=name, exact=True).click()


def pick(page, label, option):
    page.get_by_label(label, exact=True).filter(visible=True).first.click()
    page.get_by_role("option", name=option, exact=True).click()


def set_time(page, text):
    row = page.get_by_text("Time [s]").locator("xpath=ancestor::*[.//input[@type='text' or @inputmode]][1]")
    box = row.get_by_role("textbox").first
    box.fill(text)
    box.press("Enter")


def fetch(page, button, name, timeout=PATIENCE):
    """Content of the file that a button offers for download."""
    with page.expect_download(timeout=timeout) as download:
        click(page, button)
    assert download.value.suggested_filename == name
    return Path(download.value.path()).read_bytes()


def wait_until(page, holds):
    for _ in range(600):
        if holds():
            return
        page.wait_for_timeout(100)
    raise AssertionError("it does not come to hold")


def settle(page, take_picture, name, before=None):
    """A picture of the scene that stays, another than ``before`` where one is given."""
    last = take_picture(page, name)
    for _ in range(60):
        page.wait_for_timeout(250)
        now = take_picture(page, name)
        if np.array_equal(now, last) and (before is None or differ(now, before)):
            return now
        last = now
    raise AssertionError("the picture does not settle, or does not change")


def differ(one, other):
    return (np.abs(one - other).max(axis=2) > 30).mean() > 0.002


def test_a_grasp_is_run_watched_scrubbed_and_played(fakes, studio, open_page, take_picture):
    page = open_page(studio([GraspTab]))
    wait_for(page, "predicted chance 98%")
    start = settle(page, take_picture, "start")
    click(page, "Run grasp")
    wait_for(page, "Computing.")
    wait_for(page, "prehension")
    middle = settle(page, take_picture, "middle", before=start)
    fakes.go.set()
    wait_for(page, "Success.")
    end = settle(page, take_picture, "end", before=middle)
    assert page.locator(".uplot canvas").count() == 3
    set_time(page, "0.5")
    wait_for(page, "0.5 s")
    early = settle(page, take_picture, "early", before=end)
    click(page, "Play")
    wait_for(page, "3.0 s")
    page.get_by_role("button", name="Play", exact=True).wait_for(timeout=PATIENCE)
    assert not differ(settle(page, take_picture, "played", before=early), end)
    assert json.loads(fetch(page, "Result (JSON)", "result.json"))["success"] is True


def test_the_checkbox_darkens_the_floor_of_the_scene(fakes, studio, open_page, take_picture):
    page = open_page(studio([GraspTab]))
    wait_for(page, "predicted chance")
    light = settle(page, take_picture, "light")
    page.get_by_label("Dark", exact=True).click()
    dark = settle(page, take_picture, "dark", before=light)
    foot = slice(-light.shape[0] // 4, None)  # Where the floor is in front of robot and object.
    assert dark[foot, : light.shape[1] // 2].mean() < 0.5 * light[foot, : light.shape[1] // 2].mean()


def test_a_run_that_is_stopped_leaves_its_frames(fakes, studio, open_page):
    page = open_page(studio([GraspTab]))
    wait_for(page, "predicted chance")
    click(page, "Run grasp")
    wait_for(page, "Computing.")
    click(page, "Stop")
    wait_for(page, "Stopped. The frames so far are in the timeline.")
    page.get_by_role("slider", name="Time [s]", exact=True).wait_for(timeout=PATIENCE)
    assert page.get_by_role("button", name="Run grasp", exact=True).is_visible()
    assert page.get_by_role("button", name="Stop", exact=True).count() == 0
    set_time(page, "0.2")
    wait_for(page, "0.2 s")
    kept = page.get_by_text("Phases:").filter(visible=True).inner_text()
    assert "prehension" in kept  # The frames that had arrived,
    assert "transport" not in kept  # and no later ones.


@pytest.mark.slow
def test_after_a_stopped_run_the_grasp_before_is_offered_and_a_choice_shows_its_scene(
    fakes, studio, open_page, take_picture
):
    fakes.go.set()
    page = open_page(studio([GraspTab]))
    wait_for(page, "predicted chance")
    start = settle(page, take_picture, "start")
    click(page, "Run grasp")
    wait_for(page, "cylinder-60 by wrap-vertical: Success.")
    fakes.go.clear()
    pick(page, "Object", "box-80")
    click(page, "Run grasp")
    wait_for(page, "Computing.")
    click(page, "Show again: wrap-vertical, cylinder-60, seed 0")
    wait_for(page, "a grasp is being computed; wait for its end, or stop it")
    click(page, "Stop")
    wait_for(page, "box-80 by wrap-vertical: Stopped.")
    click(page, "Play")
    click(page, "Show again: wrap-vertical, cylinder-60, seed 0")
    wait_for(page, "cylinder-60 by wrap-vertical: Success.")
    assert page.get_by_role("button", name="Play", exact=True).is_visible(), "the run that was stopped plays on"
    pick(page, "Object", "box-60")
    page.get_by_text("Success.").filter(visible=True).wait_for(state="detached", timeout=PATIENCE)
    again = settle(page, take_picture, "again")
    assert (np.abs(again - start).max(axis=2) > 30)[:, 330:].mean() < 0.01


@pytest.mark.slow
def test_the_picker_tells_why_and_takes_measures_and_files(fakes, studio, open_page):
    page = open_page(studio([GraspTab]))
    wait_for(page, "predicted chance")
    pick(page, "Object", "rod-20")
    wait_for(page, "cannot take it: too thin for the trunk")
    pick(page, "Object", "by its measures")
    pick(page, "Solid", "sphere")
    wait_until(page, lambda: fakes.requests[-1].name == "sphere:diameter_mm=60,mass_g=250")
    pick(page, "Stage", "ground")
    wait_for(page, "tries the best first")
    wait_until(page, lambda: (fakes.requests[-1].stage, fakes.requests[-1].strategy) == ("ground", "auto"))
    pick(page, "Object", "from a file (STL, OBJ)")
    wait_for(page, "No file yet")
    mesh = trimesh.creation.box((40.0, 50.0, 120.0))
    upload = page.locator("input[type=file]").first
    upload.set_input_files(
        {"name": "../../etc/cup.stl", "mimeType": "model/stl", "buffer": mesh.export(file_type="stl")}
    )
    wait_for(page, "the unit is guessed from the size: mm")
    wait_until(page, lambda: fakes.requests[-1].name == "cup.stl")
    assert fakes.requests[-1].shape.size == pytest.approx((0.12, 0.04, 0.05))
    upload.set_input_files({"name": "cup.stl", "mimeType": "model/stl", "buffer": b"no solid"})
    wait_for(page, "no STL that can be read")
    page.reload()
    wait_for(page, "No file yet")
    assert page.get_by_label("Object", exact=True).first.input_value() == "from a file (STL, OBJ)"
    wait_for(page, "the object's file is missing")
    pick(page, "Object", "by its measures")
    pick(page, "Solid", "ring")
    tube = page.get_by_text("Tube [mm]").locator("xpath=ancestor::*[.//input[@type='text' or @inputmode]][1]")
    tube.get_by_role("textbox").first.fill("200")
    tube.get_by_role("textbox").first.press("Enter")
    wait_for(page, "Outer diameter [mm] is 90")


@pytest.mark.slow
def test_a_reload_comes_back_to_what_was_picked(fakes, studio, open_page):
    page = open_page(studio([GraspTab]))
    wait_for(page, "predicted chance")
    pick(page, "Object", "box-80")
    wait_for(page, "predicted chance")
    page.reload()
    wait_for(page, "predicted chance")
    assert page.get_by_label("Object", exact=True).first.input_value() == "box-80"
    assert fakes.requests[-1].name == "box-80"


@pytest.mark.slow
def test_a_reload_comes_back_to_the_grasp_until_another_is_picked(fakes, studio, open_page, take_picture):
    fakes.go.set()
    page = open_page(studio([GraspTab]))
    wait_for(page, "predicted chance")
    click(page, "Run grasp")
    wait_for(page, "Success.")
    end = settle(page, take_picture, "end")
    page.reload()
    wait_for(page, "Success.")
    wait_for(page, "predicted chance")
    assert not differ(settle(page, take_picture, "reloaded"), end)
    assert json.loads(fetch(page, "Result (JSON)", "result.json"))["success"] is True
    pick(page, "Object", "box-80")
    page.get_by_text("Success.").filter(visible=True).wait_for(state="detached", timeout=PATIENCE)
    still = settle(page, take_picture, "still", before=end)
    click(page, "Show again: wrap-vertical, cylinder-60, seed 0")
    wait_for(page, "Success.")
    again = settle(page, take_picture, "again", before=still)
    changes = [(np.abs(one - end).max(axis=2) > 30)[:, 330:].mean() for one in (again, still)]  # Beside the notices.
    assert 5 * changes[0] < changes[1], "the ball is back"
    assert json.loads(fetch(page, "Result (JSON)", "result.json"))["success"] is True
    assert page.get_by_role("button", name="Show again").count() == 0


@pytest.mark.slow
def test_a_reload_during_a_grasp_tells_that_it_was_stopped_and_what_is_shown(fakes, studio, open_page):
    fakes.go.set()
    page = open_page(studio([GraspTab]))
    wait_for(page, "predicted chance")
    click(page, "Run grasp")
    wait_for(page, "cylinder-60 by wrap-vertical: Success.")
    fakes.go.clear()
    pick(page, "Object", "box-80")
    page.get_by_text("Success.").filter(visible=True).wait_for(state="detached", timeout=PATIENCE)
    click(page, "Run grasp")
    wait_for(page, "Computing.")
    page.reload()
    told = "The grasp of box-80 by wrap-vertical was stopped by the reload."
    page.get_by_role("alert").filter(has_text=told).wait_for(timeout=PATIENCE)
    wait_for(page, f"Note: {told}")
    assert page.get_by_text("Success.").filter(visible=True).count() == 0, "the grasp before was of another object"
    pick(page, "Object", "cylinder-60")
    page.get_by_text(f"Note: {told}").filter(visible=True).wait_for(state="detached", timeout=PATIENCE)
    fakes.go.set()
    click(page, "Run grasp")
    wait_for(page, "cylinder-60 by wrap-vertical: Success.")
    fakes.go.clear()
    click(page, "Run grasp")
    wait_for(page, "Computing.")
    page.reload()
    wait_for(
        page, f"Note: {told.replace('box-80', 'cylinder-60')} What is shown is the grasp before, of cylinder-60 by"
    )
    wait_for(page, "cylinder-60 by wrap-vertical: Success.")
    wait_for(page, "cylinder-60 by wrap-vertical. The same by a command")


@pytest.mark.slow
def test_the_arrow_keys_step_the_time_by_one_frame(fakes, studio, open_page):
    fakes.go.set()
    tabs = []

    def build(page):
        tabs.append(GraspTab(page))
        return tabs[-1]

    page = open_page(studio([build]))
    wait_for(page, "predicted chance")
    click(page, "Run grasp")
    wait_for(page, "Success.")
    set_time(page, "1")
    panel = tabs[0].panel
    wait_until(page, lambda: panel._index == RATE)
    slider = page.get_by_role("slider", name="Time [s]", exact=True)
    slider.focus()
    for count in range(1, 13):
        slider.press("ArrowRight")
        page.wait_for_timeout(120 if count < 10 else 1500)  # At the end the slider rests after each step.
        wait_until(page, lambda count=count: panel._index == RATE + count)
    for _ in range(20):
        slider.press("ArrowLeft")
    wait_until(page, lambda: panel._index == RATE - 8)
    page.wait_for_timeout(1500)
    assert panel._index == RATE - 8
    assert float(slider.get_attribute("aria-valuenow")) == pytest.approx(1 - 8 / RATE, abs=1e-3)


@pytest.mark.slow
def test_what_a_person_wrote_is_no_markup(fakes, studio, open_page, monkeypatch):
    text = "got '<img src=x onerror=document.title=1> *a* [b](http://c) _d_'; allowed: flange"

    def refuse(job, report, request):
        raise ModelError(text)

    monkeypatch.setattr(fakes, "run_grasp", refuse)
    monkeypatch.setattr(fakes, "prepare", refuse)
    page = open_page(studio([GraspTab]))
    wait_for(page, f"The models cannot tell: {text}")
    click(page, "Run grasp")
    wait_for(page, f"Not run: {text}")
    assert page.title() == "spiraltrunk studio"
    assert page.locator("img[src=x]").count() == 0


@pytest.mark.slow
def test_a_kick_is_simulated_and_shown(studio, open_page, take_picture, monkeypatch):
    monkeypatch.setenv("MUJOCO_GL", os.environ.get("MUJOCO_GL") or "egl")  # As the command does.
    minutes = 10 * 60_000  # The first run on a computer compiles.
    page = open_page(studio([GraspTab]))
    wait_for(page, "predicted chance", timeout=minutes)
    pick(page, "Stage", "ground")
    pick(page, "Strategy", "kick")
    wait_for(page, "kick can take it", timeout=minutes)
    start = settle(page, take_picture, "start")
    click(page, "Run grasp")
    wait_for(page, "Computing.", timeout=minutes)
    page.get_by_text("Success.").or_(page.get_by_text("Failed:")).first.wait_for(timeout=minutes)
    settle(page, take_picture, "end", before=start)
    replay = fetch(page, "Replay (HTML)", "replay.html", minutes)
    assert replay.lower().startswith(b"<!doctype html")
    assert len(replay) < 10e6
    assert fetch(page, "Film strip (PNG)", "filmstrip.png", minutes).startswith(b"\x89PNG")
