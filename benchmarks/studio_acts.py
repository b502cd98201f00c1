"""Which acts of a person make the browser page grow, and what of its memory: one act repeated in a fresh page.

For each kind of act a studio and a headless Chromium are started, and a script in the page repeats the act. After each
round the memory of the page's process is read, the garbage collected before: anonymous memory, memory shared with the
GPU process, mapped files (the program's code, as far as it was used), the JavaScript heap, and the number of WebGL
objects that the page holds. The last row is read after a signal of memory pressure. A leak grows by the same amount
each round, also late; caches and compiled functions level off. The GPU process draws where there is no graphics card,
and is read apart. `--allocators` and `--snapshots` tell what is more at the end than after the first round; a snapshot
takes some 30 MB itself, once.

    python benchmarks/studio_acts.py --kinds design tabs --acts 300
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from playwright.sync_api import Browser, CDPSession, Page, sync_playwright

sys.path.insert(0, str(Path(__file__).parent))

from studio_hours import FLAGS, KINDS_OF_MEMORY, read_kind

SIZE = {"width": 1000, "height": 400}
"""A small window, which software draws sooner [px]."""

PATIENCE = 120_000
"""Time that a busy computer has [ms]."""

_ACTS = """
window.benchmarkActs = (() => {
  const wait = (time) => new Promise((resolve) => setTimeout(resolve, time));
  const shown = (name) => [...document.querySelectorAll("button")]
    .find((one) => one.textContent === name && one.offsetParent !== null);
  const press = (slider, key) => slider.dispatchEvent(new KeyboardEvent("keydown", { key, code: key, bubbles: true }));
  const titles = ["Design", "Shape", "Grasp", "Measure", "Robot"];
  const slide = async (i) => {
    let sliders = [];
    while (sliders.length < 3) {
      await wait(50);
      sliders = [...document.querySelectorAll("[role=slider]")].filter((one) => one.offsetParent !== null);
    }
    press(sliders[Math.floor(i / 10) % 3], i % 10 < 5 ? "ArrowRight" : "ArrowLeft");
    await wait(100);
  };
  const draw = (seed) => () => {  // The generator mulberry32.
    seed = (seed + 0x6D2B79F5) | 0;
    let t = Math.imul(seed ^ (seed >>> 15), 1 | seed);
    t = (t + Math.imul(t ^ (t >>> 7), 61 | t)) ^ t;
    return ((t ^ (t >>> 14)) >>> 0) / 4294967296;
  };
  const acts = {
    design: slide, shape: slide,
    tabs: async (i) => { shown(titles[i % 5]).click(); await wait(300); },
    play: async () => { shown("Play")?.click(); await wait(2000); shown("Pause")?.click(); await wait(500); },
    scene: async (i) => {
      shown("Design").click();
      await wait(400);
      await slide(i);
      shown("Grasp").click();
      await wait(1200);
    },
    wait: () => wait(1000),
    mix: async (i) => {
      const chance = draw(i);
      const tab = titles[Math.floor(5 * chance())];
      shown(tab).click();
      await wait(800);
      const buttons = { Grasp: [shown("Play") ? "Play" : "Run grasp"], Robot: ["Connect", "Take control", "Home"] };
      for (const name of buttons[tab] ?? []) {
        shown(name)?.click();
        await wait(name === "Play" ? 2500 : 300);
      }
      if (tab === "Grasp") shown("Pause")?.click();
      for (let n = tab === "Design" || tab === "Shape" ? 1 + Math.floor(7 * chance()) : 0; n > 0; n--)
        await slide(Math.floor(30 * chance()));
    },
  };
  return async (kind, first, n) => { for (let i = first; i < first + n; i++) await acts[kind](i); };
})();
"""
"""The acts, by the page's own controls. To drive each from outside would add memory of what drives."""

_WEBGL = """
window.benchmarkWebgl = 0;
for (const [name, call] of Object.entries(Object.getOwnPropertyDescriptors(WebGL2RenderingContext.prototype))) {
  const [, verb] = /^(create|delete)(?:Buffer|Texture|Program|Shader|VertexArray|Framebuffer|Renderbuffer|Query)$/
    .exec(name) ?? [];
  if (verb) WebGL2RenderingContext.prototype[name] = function (...given) {
    if (verb === "create" || given[0]) window.benchmarkWebgl += verb === "create" ? 1 : -1;
    return call.value.apply(this, given);
  };
}
"""
"""Counts the objects that the page has made in WebGL and not deleted."""

KINDS = {
    "design": ("Design", "design"), "shape": ("Shape", "shape"), "tabs": ("Design", "tabs"), "play": ("Grasp", "play"),
    "scene": ("Grasp", "scene"), "robot": ("Robot", "wait"), "still": ("Grasp", "wait"), "mix": ("Grasp", "mix"),
}  # fmt: skip
"""Tab that is shown first, and the act, for each kind: `robot` is a second with the twin connected,
`scene` another design, for which the bodies of the tab Grasp are replaced, and
`mix` one of all, with the twin connected."""


class Watch:
    """Memory of a page and of its browser."""

    def __init__(self, browser: Browser, page: Page) -> None:
        self._browser = browser.new_browser_cdp_session()
        self._page: CDPSession = page.context.new_cdp_session(page)
        self._page.send("Performance.enable")
        self._events: list[Any] = []
        self._browser.on("Tracing.dataCollected", lambda each: self._events.extend(each["value"]))
        self._wait, self._evaluate = page.wait_for_timeout, page.evaluate
        processes = self._browser.send("SystemInfo.getProcessInfo")["processInfo"]
        pages = [one for one in processes if one["type"] == "renderer"]  # Two more are kept in reserve, and do nothing.
        self._renderers = [max(pages, key=lambda one: one["cpuTime"])["id"]]
        self._gpu = [one["id"] for one in processes if one["type"] == "GPU"]

    def read(self, *, presses: bool = False) -> dict[str, float]:
        """Memory after a garbage collection [MB], and the numbers of what the page holds."""
        for _ in range(2):
            self._page.send("HeapProfiler.collectGarbage")
            self._wait(300)
        if presses:
            self._page.send("Memory.simulatePressureNotification", {"level": "critical"})
            self._wait(5000)
        figures = {one["name"]: one["value"] for one in self._page.send("Performance.getMetrics")["metrics"]}
        return {
            **{f"page_{name}": read_kind(self._renderers, kind) for name, kind in KINDS_OF_MEMORY.items()},
            "gpu_anon_mb": read_kind(self._gpu, "RssAnon"), "heap_mb": round(figures["JSHeapUsedSize"] / 2**20, 2),
            "nodes": figures["Nodes"], "listeners": figures["JSEventListeners"], "documents": figures["Documents"],
            "webgl": self._evaluate("benchmarkWebgl"),
        }  # fmt: skip

    def dump(self) -> dict[str, float]:
        """Memory of the page's process by allocator [MB], of Chromium's own account."""
        self._events.clear()
        done: list[bool] = []
        self._browser.once("Tracing.tracingComplete", lambda _: done.append(True))
        config = {"includedCategories": ["disabled-by-default-memory-infra"], "excludedCategories": ["*"],
                  "memoryDumpConfig": {"triggers": []}}  # fmt: skip
        self._browser.send("Tracing.start", {"traceConfig": config, "transferMode": "ReportEvents"})
        self._browser.send("Tracing.requestMemoryDump", {"deterministic": True, "levelOfDetail": "detailed"})
        self._browser.send("Tracing.end")
        while not done:
            self._wait(100)
        sizes: Counter[str] = Counter()
        for event in self._events:
            if event.get("ph") == "v" and event["pid"] in self._renderers:
                for name, one in event["args"]["dumps"].get("allocators", {}).items():
                    if name.count("/") <= 3 and "size" in one.get("attrs", {}):
                        sizes[name] += int(one["attrs"]["size"]["value"], 16) / 2**20
        return dict(sizes)

    def count_objects(self) -> Counter[str]:
        """Size of all objects of the JavaScript heap, and of the browser's own, by kind and name [bytes]."""
        parts: list[str] = []
        take = lambda each: parts.append(each["chunk"])  # noqa: E731
        self._page.on("HeapProfiler.addHeapSnapshotChunk", take)
        self._page.send("HeapProfiler.takeHeapSnapshot", {"reportProgress": False, "exposeInternals": True})
        self._page.remove_listener("HeapProfiler.addHeapSnapshotChunk", take)
        taken = json.loads("".join(parts))
        meta, nodes, names = taken["snapshot"]["meta"], taken["nodes"], taken["strings"]
        fields, kinds = meta["node_fields"], meta["node_types"][0]
        at = {name: fields.index(name) for name in ("type", "name", "self_size")}
        sizes: Counter[str] = Counter()
        for i in range(0, len(nodes), len(fields)):
            kind, name = kinds[nodes[i + at["type"]]], names[nodes[i + at["name"]]][:60]
            sizes[f"{kind}: {name}"] += nodes[i + at["self_size"]]
        return sizes


@contextmanager
def serve() -> Iterator[str]:
    """Address of a studio in a process of its own."""
    command = [sys.executable, "-m", "spiraltrunk", "studio", "--port", "0", "--no-browser", "--json"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as server:
        try:
            assert server.stdout is not None
            yield json.loads(server.stdout.readline())["address"]
        finally:
            server.terminate()


def prepare(page: Page, kind: str) -> None:
    """Show the tab of a kind, run a grasp that can be played, or connect the twin."""
    title = KINDS[kind][0]
    page.get_by_role("button", name=title, exact=True).click()
    page.get_by_role("button", name=title, exact=True, pressed=True).wait_for()
    if kind in ("play", "mix"):
        page.get_by_role("button", name="Run grasp").click()
        page.get_by_role("button", name="Play", exact=True).wait_for(timeout=5 * PATIENCE)
    if kind == "mix":
        page.get_by_role("button", name="Robot", exact=True).click()
    for name in ("Connect", "Take control", "Home") if kind in ("robot", "mix") else ():
        page.wait_for_timeout(3000)
        button = page.get_by_role("button", name=name, exact=True).filter(visible=True)
        if button.count():
            button.first.click()
    page.evaluate(_ACTS)


def measure(kind: str, arguments: argparse.Namespace) -> list[dict[str, Any]]:
    """Memory after each round of one kind of act; what grew most between the first and the last is printed."""
    rows: list[dict[str, Any]] = []
    seen: dict[str, list[dict[str, float]]] = {"allocators": [], "objects": []}
    with serve() as address, sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=FLAGS)
        page = browser.new_page(viewport=SIZE)  # type: ignore[arg-type]
        page.set_default_timeout(PATIENCE)
        page.add_init_script(_WEBGL)
        page.goto(address)
        page.get_by_role("button", pressed=True).wait_for()
        prepare(page, kind)
        watch, n_each = Watch(browser, page), arguments.acts // arguments.rounds
        end = time.perf_counter() + 60 * arguments.minutes
        for i in range(arguments.rounds):
            began = time.perf_counter()
            if began > end:
                break
            page.evaluate("([kind, i, n]) => benchmarkActs(kind, i, n)", [KINDS[kind][1], i * n_each, n_each])
            spent = round(time.perf_counter() - began, 1)
            page.get_by_role("button", name=KINDS[kind][0], exact=True).click()  # The same tab whenever it is read.
            page.wait_for_timeout(1000)
            rows.append({"kind": kind, "acts": (i + 1) * n_each, "s": spent, "load": os.getloadavg()[0]} | watch.read())
            print(json.dumps(rows[-1]), file=sys.stderr, flush=True)
            if i in (0, arguments.rounds - 1):
                seen["allocators"] += [watch.dump()] if arguments.allocators else []
                seen["objects"] += [watch.count_objects()] if arguments.snapshots else []
        rows.append({"kind": kind, "acts": rows[-1]["acts"], "pressure": True} | watch.read(presses=True))
        print(json.dumps(rows[-1]), file=sys.stderr, flush=True)
        browser.close()
    for name, (first, last) in ((name, both) for name, both in seen.items() if len(both) == 2):
        grown = {each: last[each] - first.get(each, 0.0) for each in last}
        print(f"{name} of {kind} that grew most:", file=sys.stderr)
        for each in sorted(grown, key=lambda each: -abs(grown[each]))[:25]:
            print(f"{grown[each]:+12.2f} to {last[each]:12.2f}  {each}", file=sys.stderr)
    return rows


def main() -> int:
    """Print JSON."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--kinds", nargs="+", choices=tuple(KINDS), default=["design", "tabs"], help="kinds of acts")
    parser.add_argument("--acts", type=int, default=300, metavar="N", help="acts of each kind (default 300)")
    parser.add_argument("--rounds", type=int, default=5, metavar="N", help="rounds of acts (default 5)")
    parser.add_argument("--minutes", type=float, default=60.0, metavar="T", help="no round begins later (default 60)")
    parser.add_argument("--allocators", action="store_true", help="also what grew of each allocator of Chromium [MB]")
    parser.add_argument("--snapshots", action="store_true", help="also which objects of the heap grew [bytes]")
    arguments = parser.parse_args()
    print(json.dumps([row for kind in arguments.kinds for row in measure(kind, arguments)]))
    return 0


if __name__ == "__main__":
    sys.exit(main())
