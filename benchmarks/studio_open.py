"""How long the browser page takes to open, and whether a server that is used for hours grows.

Claims (docs/tutorials/studio.md): the page can be used seconds after the command, once compiled, and the memory of the
server does not grow. A headless Chromium opens pages, shows each tab, moves one of its sliders, and reloads now and
then. Times depend on the machine; its load is told beside them.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from playwright.sync_api import Browser, Page, sync_playwright

FLAGS = [
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-sync",
    "--disable-background-networking", "--disable-component-update", "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader", "--enable-webgl",
]  # fmt: skip
"""Flags with which Debian's Chromium draws WebGL without a screen or a GPU."""

TITLES = ("Design", "Shape", "Grasp", "Measure", "Robot")


@contextmanager
def serve() -> Iterator[tuple[subprocess.Popen[str], str]]:
    """A studio in a process of its own, and its address."""
    command = [sys.executable, "-m", "spiraltrunk", "studio", "--port", "0", "--no-browser", "--json"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as server:
        try:
            assert server.stdout is not None
            yield server, json.loads(server.stdout.readline())["address"]
        finally:
            server.terminate()


@contextmanager
def browse() -> Iterator[Browser]:
    """A headless Chromium."""
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=FLAGS)
        yield browser
        browser.close()


def measure_start(browser: Browser) -> dict[str, float]:
    """Time from the command to its address, and to a page whose first tab is shown [s]."""
    began = time.perf_counter()
    with serve() as (_, address):
        listening = time.perf_counter() - began
        page = browser.new_page(viewport={"width": 1280, "height": 800})
        page.goto(address)
        page.get_by_role("button", pressed=True).wait_for()
        usable = time.perf_counter() - began
        page.close()
    return {"listening_s": round(listening, 2), "usable_s": round(usable, 2)}


def use_page(page: Page, chance: random.Random) -> None:
    """Show a tab and type into one of its boxes."""
    title = chance.choice(TITLES)
    page.get_by_role("button", name=title, exact=True).click()
    page.get_by_role("button", name=title, exact=True, pressed=True).wait_for()
    sliders = page.get_by_role("slider").filter(visible=True)
    if sliders.count():
        slider = sliders.nth(chance.randrange(min(sliders.count(), 4)))
        slider.focus()
        for _ in range(chance.randrange(1, 8)):
            slider.press(chance.choice(("ArrowLeft", "ArrowRight")))
    page.wait_for_timeout(500)


def read_memory(process: int) -> float:
    """Resident memory of a process [MB]."""
    lines = Path(f"/proc/{process}/status").read_text().splitlines()
    return next(int(line.split()[1]) / 1024 for line in lines if line.startswith("VmRSS"))


def soak(browser: Browser, minutes: float, seed: int) -> dict[str, Any]:
    """Memory of the server over a time of use [MB], every minute."""
    chance, seen, n_reloads = random.Random(seed), [], 0
    with serve() as (server, address):
        page = browser.new_page(viewport={"width": 1280, "height": 800})
        page.goto(address)
        began = time.perf_counter()
        while (spent := time.perf_counter() - began) < 60 * minutes:
            use_page(page, chance)
            if chance.random() < 0.05:
                n_reloads += 1
                page.reload()
                page.get_by_role("button", pressed=True).wait_for()
            if spent > 60 * len(seen):
                seen.append(round(read_memory(server.pid), 1))
                print(f"{spent / 60:.0f} min, {seen[-1]} MB", file=sys.stderr, flush=True)
    return {"minutes": minutes, "reloads": n_reloads, "memory_mb": seen, "seed": seed}


def main() -> int:
    """Print JSON."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--starts", type=int, default=3, metavar="N", help="starts to time (default 3)")
    parser.add_argument("--minutes", type=float, default=0.0, metavar="T", help="time of use (default 0)")
    parser.add_argument("--seed", type=int, default=0, help="seed of what is clicked")
    arguments = parser.parse_args()
    with browse() as browser:
        result: dict[str, Any] = {
            "load": os.getloadavg()[0],
            "starts": [measure_start(browser) for _ in range(arguments.starts)],
        }
        if arguments.minutes > 0:
            result["soak"] = soak(browser, arguments.minutes, arguments.seed)
    print(json.dumps(result))
    return 0


if __name__ == "__main__":
    sys.exit(main())
