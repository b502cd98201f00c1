"""Hours of simulated operation of the driver on the twin, with random strategies and random faults.

Claim (docs/validation/drive.md): in 8 hours no command is lost, no length drifts by more than 1 mm, memory does not
grow, and every fault is in the record, and with ``--log`` in the log, with its time and reaction. With ``--fault-period
inf``: no false alarm.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
import time
from collections import Counter
from dataclasses import asdict
from pathlib import Path

from spiraltrunk.design.presets import PAPER
from spiraltrunk.workflows.drive.soak import FAULT_PERIOD, FaultRecord, record_commands, run_soak
from spiraltrunk.workflows.drive.soak_log import check_log

NAMES = (
    "wrap-vertical", "pinch", "tip-grip", "wrap-oblique-low", "wrap-oblique", "wrap-horizontal", "flip-grip", "kick",
    "sweep",
)  # fmt: skip


REST = 1e-3
"""Cable below which a drum that something holds would not have turned anyway [m] (ours)."""


def tell_motion(record: FaultRecord) -> str:
    """A fault that was not noticed: a stall is harmless where the drum would have stood anyway."""
    if record.name != "stall" or record.turned is None:
        return "went on"
    return "went on, a drum at rest" if record.turned < REST else "went on, a drum in motion"


def main() -> int:
    """Run the soak and print what it showed."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--hours", type=float, default=8.0, metavar="H", help="simulated time (default 8)")
    parser.add_argument("--seed", type=int, default=0, metavar="N", help="seed (default 0)")
    parser.add_argument(
        "--fault-period", type=float, default=FAULT_PERIOD, metavar="S", help="mean time between faults; inf for none"
    )
    parser.add_argument(
        "--minutes", type=float, default=math.inf, metavar="M", help="end after so much real time, if it is not over"
    )
    parser.add_argument("--out", type=Path, metavar="FILE", help="write every fault and the memory there, as JSON")
    parser.add_argument("--load-cells", action="store_true", help="a load cell at each cable, and their faults")
    parser.add_argument("--log", type=Path, metavar="FILE", help="write an MCAP log, and check every fault in it")
    arguments = parser.parse_args()
    began, end = time.process_time(), time.monotonic() + 60.0 * arguments.minutes
    shown = [0.0]

    def tell(name: str, done: int, total: int) -> None:
        if done >= shown[0] + 600:
            shown[0] = done
            print(f"{done} of {total} s, {name}", file=sys.stderr, flush=True)

    commands = record_commands(PAPER, NAMES)
    result = run_soak(
        PAPER, commands, duration=3600.0 * arguments.hours, seed=arguments.seed, fault_period=arguments.fault_period,
        progress=tell, is_enough=lambda: time.monotonic() > end, log=arguments.log,
        has_cells=arguments.load_cells,
    )  # fmt: skip
    spent = time.process_time() - began
    causes = Counter((record.name or "nothing", record.kind or tell_motion(record)) for record in result.faults)
    print(f"simulated {result.simulated / 3600:.2f} h in {spent / 60:.1f} min of processor time")
    print(f"strategies {result.n_strategy}, commands {result.n_command}, lost {result.n_lost}")
    print(f"largest drift of a length {1e3 * result.drift:.3f} mm")
    sizes = [size for _, size in result.memory]
    middle = len(sizes) // 4
    print(f"memory {sizes[middle] / 1e6:.1f} MB after a quarter, {sizes[-1] / 1e6:.1f} MB at the end")
    slowest = max((record.reaction or 0.0 for record in result.faults if record.noticed is not None), default=0.0)
    print(f"faults {len(result.faults)}, slowest reaction {1e3 * slowest:.0f} ms")
    for (name, kind), count in sorted(causes.items()):
        print(f"  {name:24}{kind:32}{count}")
    if arguments.out:
        arguments.out.write_text(json.dumps(asdict(result)) + "\n", encoding="utf-8")
    if arguments.log is None:
        return 0
    check = check_log(arguments.log, result.faults)
    print(f"log of {check.n_message} messages: {check.n_noticed} faults noticed, {check.n_injected} injected")
    for problem in check.problems:
        print(f"  {problem}")
    print("the log tells every fault" if not check.problems else f"{len(check.problems)} problems")
    return int(bool(check.problems))


if __name__ == "__main__":
    sys.exit(main())
