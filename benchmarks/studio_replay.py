"""Size of a replay, frames that the page gets each second while a grasp plays, and how long a ranking takes.

Claims (docs/tutorials/grasp.md): the replay of the default grasp, 18 s, is smaller than 10 MB; while it plays in real
time the page gets 30 frames a second; the models tell within 10 s which strategy can take an object. The grasp plays in
a page of a headless Chromium. Times depend on the machine; its load is told beside them.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import sys
import time
from typing import Any, ClassVar

from playwright.sync_api import sync_playwright

from spiraltrunk.design import presets
from spiraltrunk.sim.objects.catalogue import DEFAULT_OBJECT, parse_object
from spiraltrunk.studio.grasp.replay import format_replay
from spiraltrunk.studio.grasp.stage_view import StageView
from spiraltrunk.studio.grasp.tab import GraspTab
from spiraltrunk.studio.page.page import Page
from spiraltrunk.studio.studio import Studio, StudioOptions
from spiraltrunk.workflows.grasp.choice.refusal import explain_choice
from spiraltrunk.workflows.grasp.recording import RATE, Recording, record
from spiraltrunk.workflows.grasp.trial import run_trial

FLAGS = [
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-sync",
    "--disable-background-networking", "--disable-component-update", "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader", "--enable-webgl",
]  # fmt: skip
"""Flags with which Debian's Chromium draws WebGL without a screen or a GPU."""


class QuietTab(GraspTab):  # type: ignore[misc]  # Final: here alone its models are not asked.
    """The tab without its ranking, which would use the processor meanwhile."""

    opened: ClassVar[list[QuietTab]] = []

    def __init__(self, page: Page) -> None:
        super().__init__(page)
        self.page = page
        self.opened.append(self)

    def _prepare(self) -> None:
        pass


def measure_replay(recording: Recording) -> dict[str, float]:
    """Size of the replay [MB], and the time that it takes to make [s]."""
    began, spent = time.perf_counter(), time.process_time()
    size = len(format_replay(recording).encode())
    return {
        "frames": len(recording.frames), "seconds": round(float(recording.frames.time[-1]), 2),
        "size_mb": round(size / 1e6, 2), "made_in_s": round(time.perf_counter() - began, 2),
        "made_in_cpu_s": round(time.process_time() - spent, 2),
    }  # fmt: skip


def measure_playing(recording: Recording) -> dict[str, float]:
    """Frames that are sent to a page in each second of playing [1/s], and the processor's time for each [ms]."""
    sent: list[float] = []
    shown = StageView.show

    def count(view: StageView, *arguments: Any) -> None:
        shown(view, *arguments)
        sent.append(time.perf_counter())

    studio = Studio(presets.PAPER, [QuietTab], StudioOptions(port=0))
    try:
        with sync_playwright() as playwright:
            browser = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=FLAGS)
            page = browser.new_page(viewport={"width": 1280, "height": 800})
            page.goto(studio.address)
            page.get_by_role("button", name="Run grasp").wait_for()
            tab = QuietTab.opened[-1]
            tab.page.post(lambda: tab.panel.open(recording.meshes, recording.frames))
            page.get_by_role("button", name="Play", exact=True).wait_for()
            StageView.show = count  # type: ignore[method-assign]
            spent = time.process_time()
            page.get_by_role("button", name="Play", exact=True).click()
            page.get_by_role("button", name="Pause", exact=True).wait_for()
            page.get_by_role("button", name="Play", exact=True).wait_for(timeout=300_000)
            spent = time.process_time() - spent
            browser.close()
    finally:
        StageView.show = shown  # type: ignore[method-assign]
        studio.stop()
    length = sent[-1] - sent[0]
    return {
        "sent": len(sent), "wall_s": round(length, 2), "frames_per_s": round((len(sent) - 1) / length, 2),
        "wanted_per_s": RATE, "cpu_ms_per_frame": round(1e3 * spent / len(sent), 2),
    }  # fmt: skip


def measure_ranking(stage: str) -> dict[str, float]:
    """Time of a ranking without a trial [s]; the first one of a process loads what was compiled."""
    began, spent = time.perf_counter(), time.process_time()
    explain_choice(presets.PAPER, parse_object(DEFAULT_OBJECT), stage)
    return {"s": round(time.perf_counter() - began, 2), "cpu_s": round(time.process_time() - spent, 2)}


def main() -> int:
    """Print JSON."""
    argparse.ArgumentParser(description=__doc__.partition("\n")[0]).parse_args()
    result: dict[str, Any] = {"load": os.getloadavg()[0]}
    result["ranking"] = {stage: measure_ranking(stage) for stage in ("hung", "ground")}
    recording = record(run_trial(presets.PAPER, parse_object(DEFAULT_OBJECT)))
    result["replay"] = measure_replay(recording)
    result["playing"] = measure_playing(recording)
    result["load_at_end"] = os.getloadavg()[0]
    print(json.dumps(result))
    return 0


if __name__ == "__main__":
    sys.exit(main())
