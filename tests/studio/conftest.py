"""A running studio, and pages of it in a real browser."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

pytest.importorskip("viser", reason="viser is not installed")

from spiraltrunk.design import presets
from spiraltrunk.studio.studio import Studio, StudioOptions

FLAGS = (
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update", "--disable-sync", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
    "--enable-webgl",
)  # fmt: skip
"""Flags with which Debian's Chromium draws WebGL without a screen or a GPU."""

SIZE = {"width": 1280, "height": 800}

PATIENCE = 120_000
"""Longest wait for what a page does on a busy computer, which is no figure of the page [ms]."""

LONGEST = 1800
"""Longest duration of a slow test, most of which is drawing by software [s]."""


def pytest_collection_modifyitems(items):
    """Give slow tests of the page time on a busy computer."""
    for item in items:
        if item.path.is_relative_to(Path(__file__).parent) and item.get_closest_marker("slow"):
            item.add_marker(pytest.mark.timeout(LONGEST))


@pytest.fixture
def studio():
    """Starts studios: ``studio(tabs, design=..., host=...)``; all are stopped at the end."""
    running = []

    def start(tabs, design=presets.PAPER, **options):
        running.append(Studio(design, tabs, StudioOptions(**{"port": 0, **options})))
        return running[-1]

    yield start
    for one in running:
        one.stop()


@pytest.fixture
def browser():
    """A headless Chromium for one test alone, and what drives it.

    A page that a failed test leaves open goes on drawing. In a browser that all tests share it would slow down the
    pages of all later ones, each of which waits for the same software renderer. What drives the browser leaves an event
    loop in the thread of the tests, in which those of other modules could start none.
    """
    sync_api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    program = shutil.which("chromium")
    if program is None:
        pytest.skip("no chromium here; on Debian: apt install chromium")
    with sync_api.sync_playwright() as playwright:
        one = playwright.chromium.launch(executable_path=program, args=list(FLAGS))
        yield one
        one.close()


@pytest.fixture
def open_context(browser):
    """Opens contexts, each with cookies and pages of its own: ``open_context(offline=True)``."""

    def start(**options):
        context = browser.new_context(viewport=SIZE, **options)
        context.set_default_timeout(PATIENCE)
        return context

    return start


@pytest.fixture
def open_page(open_context):
    """Opens pages: ``open_page(studio)``; each in a browser of its own with ``own=True``, else in one they share.

    It waits until a tab is shown, but with ``until_shown=False``.
    """
    shared = open_context()

    def start(one, *, own=False, address=None, until_shown=True):
        page = (open_context() if own else shared).new_page()
        page.goto(address or one.address)
        if until_shown:
            page.get_by_role("button", pressed=True).wait_for()
        return page

    return start


@pytest.fixture
def take_picture(tmp_path):
    """Takes pictures of the scene, ``take_picture(page, name)``: arrays of shape (height, width, 3), kept as files."""
    numpy = pytest.importorskip("numpy")
    image = pytest.importorskip("PIL.Image")

    def take(page, name="page"):
        file = Path(tmp_path) / f"{name}.png"
        page.screenshot(path=file, clip={"x": 0, "y": 0, "width": 860, "height": 800})
        with image.open(file) as picture:
            return numpy.asarray(picture.convert("RGB")).astype(int)

    return take
