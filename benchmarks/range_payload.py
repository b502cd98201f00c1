"""What the vertical wrap holds in simulation, beside the paper's 33 to 267 mm and 4.89 kg: widths, and masses.

A figure counts where every seed (3 by default) is lifted, carried and held still for 3 s by the trunk alone; setting it
down is not asked for. Cylinders of 240 mm, up to 15 mm from where announced, friction 0.5 to 1.2, stiffness 10 % about
the design's. Widths and masses are found by halving lists, as if what holds one held all less extreme.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from spiraltrunk import strategies
from spiraltrunk.control.loop import run
from spiraltrunk.control.messages import Observation
from spiraltrunk.control.strategy import Milestone, Status
from spiraltrunk.design import presets
from spiraltrunk.errors import SpiralTrunkError
from spiraltrunk.sim.objects.catalogue import ObjectSpec
from spiraltrunk.sim.plant import SimPlant
from spiraltrunk.sim.robot.arm import arm_limits
from spiraltrunk.workflows.grasp.verdict.evidence import Evidence, Moments
from spiraltrunk.workflows.grasp.verdict.faults import fault_conditions
from spiraltrunk.workflows.grasp.verdict.grasp_verdict import LIFT_TOLERANCE, evaluate_grasp
from spiraltrunk.workflows.grasp.world import EXACT, draw_scene

PAPER = {"width_least_m": 0.033, "width_most_m": 0.267, "payload_kg": 4.89}
"""What the paper's design claims ("Grasping by Spiraling", Results)."""

LENGTH = 0.24
"""Length of the cylinders [m]."""

LIGHT = 0.15
"""Mass at which widths are tried [kg]."""

THIN = (0.033, 0.030, 0.026, 0.022, 0.018, 0.014)
"""Diameters from what must hold to what will not [m]."""

WIDE = (0.120, 0.130, 0.140, 0.150, 0.165, 0.180, 0.200, 0.230, 0.267)
"""The same upwards [m]."""

MASSES = (0.15, 0.25, 0.35, 0.5, 0.7, 1.0, 1.5, 2.0, 2.8, 4.0, 4.89)
"""Masses to try at each of WIDTHS [kg]."""

WIDTHS = (0.033, 0.060, 0.090, 0.120)
"""Diameters whose heaviest mass is sought [m]."""


class _Done(Exception):
    """The hold is over."""


def last_held(values: Sequence[float], is_held: Callable[[float], bool]) -> float | None:
    """The last of values that are harder and harder for which something holds; None where not even the first does."""
    low, high = -1, len(values)
    while high - low > 1:
        middle = (low + high) // 2
        if is_held(values[middle]):
            low = middle
        else:
            high = middle
    return values[low] if low >= 0 else None


def hold_once(width: float, mass: float, seed: int) -> bool:
    """Whether the trunk lifts, carries and holds a cylinder of a diameter [m] and mass [kg], without any fault."""
    shape = ObjectSpec(kind="cylinder", size=(LENGTH, width, width), mass=mass)
    strategy = strategies.get("wrap-vertical")
    plant = SimPlant(presets.PAPER, draw_scene(shape, seed, strategy=strategy, spread=EXACT))
    times: dict[Milestone | None, list[float]] = {}

    def watch(observation: Observation, status: Status) -> None:
        times.setdefault(status.milestone, []).append(observation.time)
        if status.phase == "release":
            raise _Done

    try:
        run(plant, strategy, watch=watch)
    except _Done:
        return _is_held(plant, times)
    except SpiralTrunkError:
        pass
    return False


def _is_held(plant: SimPlant, times: dict[Milestone | None, list[float]]) -> bool:
    goal = plant.task.goal
    lift, carry, hold = (
        (times[milestone][0], times[milestone][-1])
        for milestone in (Milestone.LIFTED, Milestone.CARRIED, Milestone.HELD)
    )
    evidence = Evidence(
        trace=plant.trace, task=plant.task, moments=Moments(lift=lift, carry=carry, hold=hold), gave_up=None,
        warnings=plant.warnings, limits=arm_limits(plant.design.arm),
    )  # fmt: skip
    verdict = evaluate_grasp(evidence)
    is_up = abs(verdict.lift / goal.lift - 1) <= LIFT_TOLERANCE
    return all(holds for holds, _ in fault_conditions(evidence)) and is_up and verdict.hold >= goal.hold - 0.05


def every_seed(width: float, mass: float, seeds: Sequence[int]) -> bool:
    """Whether all seeds hold; the first that does not ends it."""
    for n, seed in enumerate(seeds):
        if not hold_once(width, mass, seed):
            _tell(f"{width * 1e3:.0f} mm, {mass:g} kg: {n} of {len(seeds)} held, then not")
            return False
    _tell(f"{width * 1e3:.0f} mm, {mass:g} kg: all {len(seeds)} held")
    return True


def measure(seeds: Sequence[int], table: dict[str, Any]) -> None:
    """Fill the table as figures are found, so that an interrupted run keeps what it has."""
    table["width_least_m"] = last_held(THIN, lambda width: every_seed(width, LIGHT, seeds))
    table["width_most_m"] = last_held(WIDE, lambda width: every_seed(width, LIGHT, seeds))
    for width in WIDTHS:
        most = last_held(MASSES, lambda mass, width=width: every_seed(width, mass, seeds))
        table["payload_kg"][f"{width:g}"] = most


def format_table(table: dict[str, Any]) -> str:
    """What was found beside what the paper claims, a figure a line."""

    def told(value: float | None, scale: float, unit: str) -> str:
        return "none" if value is None else f"{value * scale:g} {unit}"

    rows = [
        f"{what}: {told(table[key], 1e3, 'mm')} (paper: {PAPER[key] * 1e3:g} mm)"
        for what, key in (("thinnest", "width_least_m"), ("widest", "width_most_m"))
        if key in table
    ]
    rows += [
        f"heaviest at {float(width) * 1e3:g} mm: {told(mass, 1.0, 'kg')} (paper, at 33 mm: {PAPER['payload_kg']:g} kg)"
        for width, mass in table["payload_kg"].items()
    ]
    return "\n".join(rows)


def main(argv: Sequence[str] | None = None) -> int:
    """Measure, tell, and write range_payload.json; 130 when interrupted."""
    arguments = _parse(argv)
    table: dict[str, Any] = {"paper": PAPER, "seeds": arguments.seeds, "light_kg": LIGHT, "payload_kg": {}}
    code = 0
    try:
        measure(range(arguments.seeds), table)
    except KeyboardInterrupt:
        code = 130
    if arguments.out is not None:
        arguments.out.mkdir(parents=True, exist_ok=True)
        (arguments.out / "range_payload.json").write_text(json.dumps(table, indent=2, allow_nan=False) + "\n")
    print(format_table(table))
    return code


def _parse(argv: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0], allow_abbrev=False)
    parser.add_argument("--seeds", type=_count, default=3, metavar="N", help="seeds that must all hold (default 3)")
    parser.add_argument("--out", type=Path, metavar="DIR", help="write range_payload.json there")
    return parser.parse_args(argv)


def _count(text: str) -> int:
    if not text.isdecimal() or not 1 <= int(text) <= 1000:
        raise argparse.ArgumentTypeError(f"{text!r} given; allowed: a whole number from 1 to 1000")
    return int(text)


def _tell(line: str) -> None:
    print(line, file=sys.stderr, flush=True)


if __name__ == "__main__":
    sys.exit(main())
