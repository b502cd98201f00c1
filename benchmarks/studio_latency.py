"""Time from a slider's change to the drawn change of the page's tab "Design", measured in the browser.

Claim: the median over 200 changes is below 100 ms.

A change is typed into the number box of the ratio m. The time runs from the input event to the first animation frame
after the frame in which WebGL drew newly uploaded vertices of the trunk. Chromium draws by software here (SwiftShader),
which a GPU does faster; the load of the machine is printed with the figures.

    python benchmarks/studio_latency.py --changes 200
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import statistics
import sys

FLAGS = (
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update", "--disable-sync", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
    "--enable-webgl",
)  # fmt: skip

_WATCH = """
window.drawn = null;
window.began = null;
for (const name of ["bufferData", "bufferSubData"]) {
  const genuine = WebGL2RenderingContext.prototype[name];
  WebGL2RenderingContext.prototype[name] = function (target, ...rest) {
    const sent = rest.find((each) => each && each.byteLength);
    const isMesh = target === this.ARRAY_BUFFER && sent && sent.byteLength > 20000;
    if (isMesh && window.began !== null && window.drawn === null) {
      window.drawn = -1;
      requestAnimationFrame(() => { window.drawn = performance.now(); });
    }
    return genuine.call(this, target, ...rest);
  };
}
"""
"""Marks the frame after the one that uploads vertices of a mesh: a section's group has some 30 kB."""

_CHANGE = """
(box, value) => new Promise((resolve) => {
  window.drawn = null;
  const set = Object.getOwnPropertyDescriptor(HTMLInputElement.prototype, "value").set;
  window.began = performance.now();
  set.call(box, value);
  box.dispatchEvent(new Event("input", { bubbles: true }));
  const limit = window.began + 5000;
  const look = () => {
    if (window.drawn > 0) resolve(window.drawn - window.began);
    else if (performance.now() > limit) resolve(null);
    else setTimeout(look, 1);
  };
  look();
})
"""


def main() -> int:
    """Print the figures as JSON; 1 where the median is not below 100 ms."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--changes", type=int, default=200, help="number of changes (default 200)")
    parser.add_argument("--pause-ms", type=int, default=150, help="pause after each change (default 150)")
    arguments = parser.parse_args()
    times = measure(arguments.changes, arguments.pause_ms)
    seen = sorted(time for time in times if time is not None)
    if not seen:
        print("no change was drawn", file=sys.stderr)
        return 1
    median = statistics.median(seen)
    figures = {
        "changes": len(times), "lost": times.count(None), "median_ms": round(median, 1),
        "percentile_95_ms": round(seen[int(0.95 * (len(seen) - 1))], 1), "largest_ms": round(seen[-1], 1),
        "allowed_median_ms": 100.0, "holds": median < 100.0, "load": [round(each, 2) for each in os.getloadavg()],
        "cores": os.cpu_count(),
    }  # fmt: skip
    print(json.dumps(figures, indent=2))
    return 0 if figures["holds"] else 1


def measure(changes: int, pause: int) -> list[float | None]:
    """Time of each change [ms]; None where none was drawn in 5 s."""
    from playwright.sync_api import sync_playwright

    from spiraltrunk.design import presets
    from spiraltrunk.studio.design.tab import DesignTab
    from spiraltrunk.studio.studio import Studio, StudioOptions

    studio = Studio(presets.PAPER, [DesignTab], StudioOptions(port=0))
    try:
        with sync_playwright() as playwright:
            browser = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=list(FLAGS))
            page = browser.new_page(viewport={"width": 1280, "height": 800})
            page.add_init_script(_WATCH)
            page.goto(studio.address)
            page.get_by_text("No warnings").wait_for(timeout=60_000)
            page.wait_for_timeout(2000)
            row = page.locator("div:has(> div label)", has=page.get_by_text("Ratio m", exact=True)).last
            box = row.get_by_role("textbox").last.element_handle()
            times = []
            for i in range(changes):
                times.append(
                    page.evaluate(f"([box, value]) => ({_CHANGE})(box, value)", [box, f"{1.4 + 0.01 * (i % 37):.2f}"])
                )
                page.wait_for_timeout(pause)
            browser.close()
            return times
    finally:
        studio.stop()


if __name__ == "__main__":
    sys.exit(main())
