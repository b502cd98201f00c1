"""Whether the browser page and its server grow over hours: a page left open, the twin connected, an act now and then.

A headless Chromium keeps one page open, in control of the twin, so that its heartbeat runs. Every few seconds comes one
act of a person: a tab, a slider, some seconds of a grasp played, a jog. `--haste N` asks N times as many heartbeats a
second, as many in an hour as N hours ask. Every sample is one line of JSON in `--log`, with the memory of the server,
of the twin's process and of the browser, and the numbers of acts and messages; `--summary FILE` reads such a file, also
one whose run was killed, and prints slopes: least squares after the first tenth, with the interval of 95 % that a block
of samples apart gives (samples beside each other are alike, so the line is fitted to the means of ten blocks).
"""

from __future__ import annotations

import argparse
import json
import os
import random
import shutil
import subprocess
import sys
import threading
import time
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import numpy as np
from playwright.sync_api import CDPSession, Error, Page, sync_playwright

FLAGS = [
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-sync",
    "--disable-background-networking", "--disable-component-update", "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader", "--enable-webgl",
]  # fmt: skip
"""Flags with which Debian's Chromium draws WebGL without a screen or a GPU."""

PATIENCE = 120_000
"""Time that a busy computer has [ms]."""

BLOCKS = 10
"""Blocks whose means the slope is fitted to [-] (ours)."""

T_95 = 2.306
"""Student's t of 95 % for ten blocks and two parameters [-]."""

MEMORIES = ("server_mb", "twin_mb", "page_mb", "anon_mb", "shmem_mb", "file_mb", "heap_mb", "gpu_mb", "browser_mb")
"""Of the page's process: all that is resident, of which anonymous (its own), shared with the GPU process (buffers of
what is drawn) and mapped files (the browser's program, as far as it was used); the rest are whole processes."""

KINDS_OF_MEMORY = {"anon_mb": "RssAnon", "shmem_mb": "RssShmem", "file_mb": "RssFile"}


def read_arguments() -> argparse.Namespace:
    """Arguments of the command."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--minutes", type=float, default=480.0, metavar="T", help="time of use (default 480)")
    parser.add_argument("--every", type=float, default=60.0, metavar="S", help="seconds between acts (default 60)")
    parser.add_argument("--haste", type=float, default=1.0, metavar="N", help="times as many heartbeats (default 1)")
    parser.add_argument("--seed", type=int, default=0, help="seed of what is done")
    parser.add_argument("--log", type=Path, default=Path("studio_hours.jsonl"), metavar="FILE", help="samples")
    parser.add_argument("--summary", type=Path, metavar="FILE", help="print what a file of samples says, and end")
    parser.add_argument("--serve", type=Path, metavar="FILE", help=argparse.SUPPRESS)
    return parser.parse_args()


def serve_counted(counts: Path, haste: float) -> int:
    """The command `studio`, which writes how many messages went each way every two seconds."""
    from viser.infra._infra import WebsockClientConnection, WebsockMessageHandler

    from spiraltrunk.cli import main as run
    from spiraltrunk.studio.robot import hub

    hub.BEAT_PERIOD /= haste
    seen: Counter[str] = Counter()
    out, into = WebsockMessageHandler.queue_message, WebsockMessageHandler._handle_incoming_message

    def count_out(self: Any, message: Any) -> None:
        seen["sent"] += 1
        seen["beats"] += type(message).__name__ == "LocalStorageGetItemRequestMessage"
        out(self, message)

    async def count_in(self: Any, client_id: Any, message: Any) -> None:
        if isinstance(self, WebsockClientConnection):
            seen["received"] += 1
            seen["answers"] += type(message).__name__ == "LocalStorageGetItemResponseMessage"
        await into(self, client_id, message)

    def write() -> None:
        while True:
            fresh = counts.with_suffix(".new")
            fresh.write_text(json.dumps(seen))
            fresh.replace(counts)
            time.sleep(2.0)

    WebsockMessageHandler.queue_message = count_out  # type: ignore[method-assign]
    WebsockMessageHandler._handle_incoming_message = count_in  # type: ignore[method-assign]
    threading.Thread(target=write, daemon=True).start()
    return run(["studio", "--port", "0", "--no-browser", "--json"])


@contextmanager
def serve(counts: Path, haste: float) -> Iterator[tuple[int, str]]:
    """Number of the process of a studio, and its address."""
    command = [sys.executable, __file__, "--serve", str(counts), "--haste", str(haste)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as server:
        try:
            assert server.stdout is not None
            yield server.pid, json.loads(server.stdout.readline())["address"]
        finally:
            server.terminate()


def read_processes() -> dict[int, tuple[int, str, float, float]]:
    """Parent, command, resident memory [MB] and processor time [s] of every process."""
    found = {}
    ticks = os.sysconf("SC_CLK_TCK")
    for folder in Path("/proc").glob("[0-9]*"):
        with suppress(OSError, IndexError, ValueError):
            command = (folder / "cmdline").read_bytes().replace(b"\0", b" ").decode(errors="replace")
            fields = (folder / "stat").read_text().rpartition(")")[2].split()
            pages = int((folder / "statm").read_text().split()[1])
            used = (int(fields[11]) + int(fields[12])) / ticks
            found[int(folder.name)] = (int(fields[1]), command, pages * os.sysconf("SC_PAGE_SIZE") / 2**20, used)
    return found


def list_below(root: int, processes: dict[int, Any]) -> set[int]:
    """Processes below one."""
    below: set[int] = set()
    grown = {root}
    while grown:
        grown = {number for number, one in processes.items() if one[0] in grown} - below
        below |= grown
    return below


def read_kind(numbers: Iterable[int], kind: str) -> float:
    """Resident memory of one kind of processes [MB]."""
    lines = [line for number in numbers for line in Path(f"/proc/{number}/status").read_text().splitlines()]
    return round(sum(int(line.split()[1]) for line in lines if line.startswith(kind)) / 1024, 1)


def sample(server: int, session: CDPSession, counts: Path) -> dict[str, float]:
    """Memory and processor time of all, and the number of messages."""
    processes = read_processes()
    mine, served = list_below(os.getpid(), processes), list_below(server, processes)
    browser = {number for number in mine - served if "chrom" in processes[number][1]}
    renderers = [number for number in browser if "--type=renderer" in processes[number][1]]
    pages = {max(renderers, key=lambda number: processes[number][3])}  # Two more are kept in reserve, and do nothing.
    gpu = {number for number in browser if "--type=gpu-process" in processes[number][1]}
    session.send("HeapProfiler.collectGarbage")
    figures = {one["name"]: one["value"] for one in session.send("Performance.getMetrics")["metrics"]}
    with suppress(OSError, ValueError):
        figures |= json.loads(counts.read_text())
    of = lambda numbers: round(sum(processes[number][2] for number in numbers), 1)  # noqa: E731
    return {
        "server_mb": of({server}), "twin_mb": of(served), "page_mb": of(pages), "browser_mb": of(browser),
        "gpu_mb": of(gpu), **{name: read_kind(pages, kind) for name, kind in KINDS_OF_MEMORY.items()},
        "heap_mb": round(figures["JSHeapUsedSize"] / 2**20, 2), "nodes": figures["Nodes"],
        "cpu_s": round(sum(processes[number][3] for number in mine), 1),
        **{name: figures.get(name, 0) for name in ("sent", "received", "beats", "answers")},
    }  # fmt: skip


def show_tab(page: Page, title: str) -> None:
    """Show a tab."""
    page.get_by_role("button", name=title, exact=True).click()
    page.get_by_role("button", name=title, exact=True, pressed=True).wait_for()


def prepare(page: Page, address: str) -> None:
    """Open the page, run the grasp that is offered, connect the twin and home it."""
    page.set_default_timeout(PATIENCE)
    page.goto(address)
    page.get_by_role("button", pressed=True).wait_for()
    show_tab(page, "Grasp")
    page.get_by_role("button", name="Run grasp").click()
    page.get_by_text("Success.").or_(page.get_by_text("Failed:")).first.wait_for(timeout=5 * PATIENCE)
    show_tab(page, "Robot")
    connect(page)


def connect(page: Page) -> None:
    """Connect the twin where none is, take control and home."""
    for name in ("Connect", "Take control", "Home"):
        page.wait_for_timeout(3000)
        button = page.get_by_role("button", name=name, exact=True).filter(visible=True)
        if button.count():
            button.first.click()


def run_grasp(page: Page) -> str:
    """Run a grasp, unless one runs; its end is not waited for."""
    run = page.get_by_role("button", name="Run grasp", exact=True)
    if run.count():
        run.click()
    return "grasp"


def act(page: Page, chance: random.Random) -> str:
    """One act of a person; its name."""
    kind = chance.choice(("play", "design", "shape", "measure", "robot"))
    if kind == "play":
        show_tab(page, "Grasp")
        page.wait_for_timeout(1000)
        play = page.get_by_role("button", name="Play", exact=True)
        if not play.count():  # Another design forgets the grasp.
            return run_grasp(page)
        play.click()
        page.wait_for_timeout(3000)
        pause = page.get_by_role("button", name="Pause", exact=True)
        if pause.count():
            pause.click()
        return kind
    show_tab(page, kind.capitalize())
    if kind == "robot":
        connect(page)
    if kind in ("design", "shape"):
        slider = page.get_by_role("slider").filter(visible=True).nth(chance.randrange(3))
        slider.focus()
        for _ in range(chance.randrange(1, 8)):
            slider.press(chance.choice(("ArrowLeft", "ArrowRight")))
    return kind


def tell(line: str) -> None:
    """Print a line on standard error, with the time."""
    print(f"{time.strftime('%H:%M:%S')} {line[:500]}", file=sys.stderr, flush=True)


def count_pictures(page: Page) -> int:
    """Pictures that the page draws in 2 s: 0 where it is frozen, and few where the computer is busy."""
    program = """() => new Promise(done => {
        let count = 0, isOver = false;
        const step = () => { count += 1; if (!isOver) requestAnimationFrame(step); };
        requestAnimationFrame(step);
        setTimeout(() => { isOver = true; done(count); }, 2000);
    })"""
    return int(page.evaluate(program))


def use(arguments: argparse.Namespace) -> None:
    """Keep the page open and write a sample after each act."""
    chance, acts, n_lost = random.Random(arguments.seed), Counter[str](), 0
    counts = arguments.log.with_suffix(".counts")
    with serve(counts, arguments.haste) as (server, address), sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=FLAGS)
        page = browser.new_page(viewport={"width": 1280, "height": 800})
        page.on("pageerror", lambda error: tell(f"an error in the page: {error}"))
        page.on("crash", lambda _: tell("the page crashed"))
        page.on("console", lambda line: tell(f"console: {line.text}") if line.type in ("error", "warning") else None)
        prepare(page, address)
        page.set_default_timeout(30_000)
        session = page.context.new_cdp_session(page)
        session.send("Performance.enable")
        began = time.monotonic()
        with arguments.log.open("w") as log:
            while (spent := time.monotonic() - began) < 60 * arguments.minutes:
                try:
                    acts[act(page, chance)] += 1
                except Error as error:
                    n_lost += 1
                    tell(f"an act was lost: {str(error).splitlines()[0]}; {count_pictures(page)} pictures in 2 s")
                seen = {"minutes": round(spent / 60, 2), "acts": acts.total(), "lost": n_lost, "haste": arguments.haste}
                log.write(json.dumps(seen | sample(server, session, counts)) + "\n")
                log.flush()
                page.wait_for_timeout(max(0.0, 1000 * (began + spent + arguments.every - time.monotonic())))


def fit(times: np.ndarray, values: np.ndarray) -> tuple[float, float]:
    """Slope of the means of blocks, and the half width of its interval of 95 %, each per hour."""
    x = np.array([part.mean() for part in np.array_split(times, BLOCKS)]) / 60.0
    y = np.array([part.mean() for part in np.array_split(values, BLOCKS)])
    line = np.polyfit(x, y, 1)
    spread = np.sqrt(np.sum((y - np.polyval(line, x)) ** 2) / (BLOCKS - 2) / np.sum((x - x.mean()) ** 2))
    return float(line[0]), float(T_95 * spread)


def summarize(lines: Sequence[str]) -> dict[str, Any]:
    """What samples say: span, acts, messages, and of each memory its ends and slope."""
    rows = []
    for line in lines:
        with suppress(ValueError):  # The last line of a run that was killed.
            rows.append(json.loads(line))
    first, last = rows[0], rows[-1]
    minutes = last["minutes"] - first["minutes"]
    result: dict[str, Any] = {
        "minutes": round(minutes, 1), "samples": len(rows), "acts": last["acts"], "acts_lost": last["lost"],
        "cores_used": round((last["cpu_s"] - first["cpu_s"]) / max(60 * minutes, 1), 2),
        **{f"messages_{name}": last[name] - first[name] for name in ("sent", "received", "beats", "answers")},
    }  # fmt: skip
    result["hours_of_beats"] = round(result["messages_beats"] / 36_000, 2)  # Ten a second.
    late = [row for row in rows if row["minutes"] >= first["minutes"] + minutes / 10]
    if len(late) >= 2 * BLOCKS:
        times = np.array([row["minutes"] for row in late])
        for name in MEMORIES:
            values = np.array([row[name] for row in late])
            slope, width = fit(times, values)
            result[name] = {
                "start": float(np.median(values[: len(values) // BLOCKS])),
                "end": float(np.median(values[-(len(values) // BLOCKS) :])),
                "slope_mb_per_h": round(slope, 2), "interval_mb_per_h": round(width, 2),
                "percent_of_start_in_the_run": round(100 * slope * minutes / 60 / values[0], 2),
            }  # fmt: skip
    return result


def main() -> int:
    """Print JSON."""
    arguments = read_arguments()
    if arguments.serve is not None:
        return serve_counted(arguments.serve, arguments.haste)
    if arguments.summary is None:
        use(arguments)
    print(json.dumps(summarize((arguments.summary or arguments.log).read_text().splitlines()), indent=1))
    return 0


if __name__ == "__main__":
    sys.exit(main())
