"""Takes the pictures of tutorials/studio.md: each tab of the page after its main act, in a headless Chromium.

`python docs/studies/make_studio.py [--out DIR] [PICTURE ...]`; a picture is a tab, such as `Shape`, or one in dark
colours, such as `Shape-dark`. It needs the extra `studio`, playwright and Debian's chromium.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path

from PIL import Image
from playwright.sync_api import Browser, Page, sync_playwright

from spiraltrunk.files.atomic import atomic_file

IMAGES = Path(__file__).parents[1] / "images"

SIZE = {"width": 1280, "height": 800}

FLAGS = [
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-sync",
    "--disable-background-networking", "--disable-component-update", "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader", "--enable-webgl",
]  # fmt: skip
"""Flags with which Debian's Chromium draws WebGL without a screen or a GPU."""

DARK = "-dark"
"""End of the name of a picture in dark colours."""

LONGEST = 300_000
"""Longest wait for what a tab computes [ms]."""


def show_design(page: Page) -> None:
    """The paper's design, as it opens."""
    page.get_by_text("No warnings").wait_for(timeout=LONGEST)


def show_shape(page: Page) -> None:
    """The twist of the paper."""
    page.get_by_text("Converged").wait_for(timeout=LONGEST)
    page.get_by_role("button", name="Twist", exact=True).click()


def show_grasp(page: Page) -> None:
    """A grasp that was run, at the time when the object is held."""
    page.get_by_role("button", name="Run grasp").click()
    page.get_by_text("Success.").wait_for(timeout=LONGEST)
    box = page.get_by_role("textbox").and_(page.locator("[inputmode=decimal]")).filter(visible=True).first
    box.fill("9")
    box.press("Enter")


def show_measure(page: Page) -> None:
    """A virtual take laid over the model."""
    page.get_by_role("button", name="Record a virtual session").click()
    page.get_by_text("mean RMSE").first.wait_for(timeout=LONGEST)


def show_robot(page: Page) -> None:
    """The twin, homed and enabled, one cable wound in; that of a picture before stays connected for a while."""
    take = page.get_by_role("button", name="Take control", exact=True)
    page.get_by_role("button", name="Connect", exact=True).or_(take).click()
    for name in ("Home", "Enable"):
        page.get_by_role("button", name=name, exact=True).click(timeout=LONGEST)
    page.get_by_text("ARMED").wait_for(timeout=LONGEST)
    for _ in range(4):
        page.get_by_role("button", name="wind in", exact=True).filter(visible=True).nth(1).click()
        page.wait_for_timeout(1500)


TABS: dict[str, Callable[[Page], None]] = {
    "Design": show_design, "Shape": show_shape, "Grasp": show_grasp, "Measure": show_measure, "Robot": show_robot,
}  # fmt: skip
"""What is done in each tab before its picture."""


PICTURES = ("Design", "Shape", "Grasp", "Measure", "Measure-dark", "Robot")
"""Pictures of the tour; the robot stays connected for a while, and every tab shows STOP then."""


def main(arguments: Sequence[str]) -> int:
    """Take the pictures that are named, those of the tour without a name."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=IMAGES)
    allowed = [f"{title}{look}" for title in TABS for look in ("", DARK)]
    parser.add_argument("pictures", nargs="*", metavar="PICTURE", help=", ".join(allowed))
    given = parser.parse_args(arguments)
    if unknown := set(given.pictures) - set(allowed):
        parser.error(f"{', '.join(sorted(unknown))}; allowed: {', '.join(allowed)}")
    with open_studio() as address, sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=FLAGS)
        for name in given.pictures or PICTURES:
            page = open_page(browser, address)
            show_tab(page, name.removesuffix(DARK), is_dark=name.endswith(DARK))
            file = f"studio_{name.lower().replace('-', '_')}.png"
            write_picture(page.screenshot(timeout=LONGEST), given.out / file)
            page.close()
        browser.close()
    return 0


def open_page(browser: Browser, address: str) -> Page:
    """A page of the studio, without viser's notice that WebGL is drawn by software."""
    page = browser.new_page(viewport=SIZE)
    page.set_default_timeout(60_000)
    page.goto(address)
    page.get_by_role("button", pressed=True).wait_for()
    page.wait_for_timeout(2000)
    notice = page.get_by_text("Software WebGL rendering detected").locator("xpath=ancestor::*[@role='alert']")
    if notice.count():
        notice.get_by_role("button").click()
    return page


def show_tab(page: Page, title: str, *, is_dark: bool) -> None:
    """Show a tab after its main act."""
    page.get_by_role("button", name=title, exact=True).click()
    shown = page.get_by_role("button", name=title, exact=True, pressed=True)
    shown.wait_for()
    page.get_by_role("checkbox", name="Dark").set_checked(is_dark)
    shown.scroll_into_view_if_needed()
    TABS[title](page)
    page.mouse.move(430, 790)
    page.wait_for_timeout(4000)


@contextmanager
def open_studio() -> Iterator[str]:
    """Address of a studio in a process of its own."""
    command = [sys.executable, "-m", "spiraltrunk", "studio", "--port", "0", "--no-browser", "--json"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=dict(os.environ)) as server:
        try:
            assert server.stdout is not None
            yield str(json.loads(server.stdout.readline())["address"])
        finally:
            server.terminate()


def write_picture(content: bytes, path: Path) -> None:
    """Write a screenshot without the transparent channel; fewer colours would falsify the scale of errors."""
    with Image.open(BytesIO(content)) as picture, atomic_file(path) as file:
        picture.convert("RGB").save(file, format="PNG", optimize=True)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
