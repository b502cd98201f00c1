"""How long the first answer takes where no kernel is compiled yet: each call in a process with an empty cache.

Claim (docs/validation/performance.md): no command and no call compiles for more than 15 s on two cores. Times depend on
the machine and on what else it does: wall-clock and processor time are both told, of the best of ``--repeats`` runs.
"""

from __future__ import annotations

import argparse
import os
import resource
import subprocess
import sys
import tempfile
import time

MODEL = "from spiraltrunk.design.presets import PAPER; from spiraltrunk.model import inverse, reference, statics; "
CALLS = {
    "shape (reference)": ["-m", "spiraltrunk", "shape", "--dorsal-mm", "50"],
    "shape (statics)": ["-m", "spiraltrunk", "shape", "--model", "statics", "--cables-mm", "30", "0", "0"],
    "shape (statics, friction)": [
        "-m", "spiraltrunk", "shape", "--model", "statics", "--cables-mm", "30", "0", "0", "--friction", "0.15"
    ],
    "statics, quasi-static": [
        "-c", MODEL + "o = statics.StaticsOptions(quasi_static=statics.QuasiStatic()); "
        "statics.solve(PAPER, tension=[1.0, 0.0, 0.0], options=o)"
    ],
    "reference.bend_dorsal_points": ["-c", MODEL + "reference.bend_dorsal_points(PAPER, [0.05], 0.4)"],
    "inverse.solve": ["-c", MODEL + "inverse.solve(PAPER, [0.1, -0.4, 0.0])"],
    "inverse.solve, friction": ["-c", MODEL + "inverse.solve(PAPER, [0.1, -0.4, 0.0], friction=0.15)"],
    "grasp": ["-m", "spiraltrunk", "grasp", "--no-video"],
    "python -c pass": ["-c", "pass"],
}  # fmt: skip
"""Arguments of Python, by what is asked for first."""


def measure(arguments: list[str]) -> tuple[float, float]:
    """Wall-clock and processor time of one process with an empty cache [s]."""
    with tempfile.TemporaryDirectory() as cache:
        environment = {**os.environ, "NUMBA_CACHE_DIR": cache}
        before, began = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
        subprocess.run([sys.executable, *arguments], env=environment, check=True, capture_output=True)
        wall, after = time.perf_counter() - began, resource.getrusage(resource.RUSAGE_CHILDREN)
    return wall, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main() -> int:
    """Print a table."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--repeats", type=int, default=1, metavar="N", help="runs of each call (default 1)")
    repeats = parser.parse_args().repeats
    print(f"{'first call':<30}{'wall [s]':>10}{'processor [s]':>15}")
    for name, arguments in CALLS.items():
        wall, busy = min(measure(arguments) for _ in range(max(1, repeats)))
        print(f"{name:<30}{wall:>10.1f}{busy:>15.1f}", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
