"""Drums that something holds at random moments of the strategies: which would have turned, and which are noticed.

Claim (docs/validation/drive.md): a stall that goes on unnoticed concerns a drum that would have stood anyway, or one of
the cases of SAFETY.md. Each stall happens in a process of its own, forked from the run that goes on without it; that
run tells how far the drum would have turned. Not on Windows.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
from collections.abc import Sequence
from typing import NamedTuple, final

import numpy as np

from spiraltrunk import strategies
from spiraltrunk.control.messages import Command
from spiraltrunk.design.presets import PAPER
from spiraltrunk.hardware.safety.states import Mode
from spiraltrunk.hardware.twin.faults import build_fault
from spiraltrunk.workflows.drive.robot import RENEWAL
from spiraltrunk.workflows.drive.soak import FAULT_TIME, record_commands
from spiraltrunk.workflows.drive.twin.twin_robot import TwinOptions, TwinRobot

N_COMMAND = round(FAULT_TIME / RENEWAL)
"""Commands within the time of a stall [-]."""

REST, LITTLE = 1e-3, 1e-2
"""Cable below which a drum would have stood, and below which it would have turned little [m] (ours)."""


@final
class Stall(NamedTuple):
    """One stall."""

    strategy: str
    start: int
    """Command at which it begins."""
    cable: int
    told: str | None
    """What the driver called it; None where it went on."""
    after: float
    """Time until then [s]."""
    turned: float = 0.0
    """Cable that the drum winds to and fro in that time without the stall [m]."""


def give(robot: TwinRobot, command: Command) -> None:
    """One command, unless the driver has stopped."""
    if robot.driver.mode is Mode.ARMED:
        robot.driver.set_targets(command.cable_tension, command.cable_pull, valid_for=RENEWAL)
    robot.run(RENEWAL)


def fork_stall(robot: TwinRobot, strategy: str, commands: Sequence[Command], index: int, cable: int) -> Stall:
    """The stall in a process of its own; the robot here is as before."""
    reader, writer = os.pipe()
    child = os.fork()
    if child == 0:
        began = robot.clock.now()
        robot.faults.inject(build_fault("stall", {"cable": cable}), at=began)
        for command in commands[index : index + N_COMMAND]:
            give(robot, command)
        fault = robot.driver.faults[0] if robot.driver.faults else None
        told = (None, FAULT_TIME) if fault is None else (fault.kind.value, fault.time - began)
        os.write(writer, json.dumps(told).encode())
        os._exit(0)
    os.close(writer)
    with os.fdopen(reader, "rb") as pipe:
        told, after = json.loads(pipe.read())
    os.waitpid(child, 0)
    return Stall(strategy, index, cable, told, after)


def run_strategy(
    robot: TwinRobot, name: str, commands: Sequence[Command], moments: list[tuple[int, int]]
) -> list[Stall]:
    """The strategy without a fault, with a stall aside at each moment (command, cable)."""
    stalls, wound = [], []
    for index, command in enumerate(commands):
        stalls += [fork_stall(robot, name, commands, index, cable) for at, cable in moments if at == index]
        give(robot, command)
        wound.append([motor.wound for motor in robot.motors.motors])
        robot.raise_fault()
    way = np.array(wound)
    return [s._replace(turned=float(np.ptp(way[s.start : s.start + N_COMMAND, s.cable]))) for s in stalls]


def main() -> int:
    """Print every stall and a summary."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0], allow_abbrev=False)
    parser.add_argument("strategies", nargs="*", metavar="STRATEGY", help="strategies (default: all)")
    parser.add_argument("--stalls", type=int, default=8, metavar="N", help="stalls in each strategy (default 8)")
    parser.add_argument("--seed", type=int, default=0, metavar="N", help="seed of their moments and cables (default 0)")
    arguments = parser.parse_args()
    played = record_commands(PAPER, arguments.strategies or strategies.NAMES)
    rng = np.random.default_rng(arguments.seed)
    found: list[Stall] = []
    with TwinRobot(PAPER, options=TwinOptions(seed=arguments.seed)) as robot:
        robot.prepare()
        for name, commands in played.items():
            starts = rng.integers(0, len(commands) - N_COMMAND, arguments.stalls)
            cables = rng.integers(0, PAPER.n_cable, arguments.stalls)
            stalls = run_strategy(robot, name, commands, [*zip(starts.tolist(), cables.tolist(), strict=True)])
            for one in stalls:
                told = "went on" if one.told is None else f"{one.told} after {one.after:.2f} s"
                where = f"{one.strategy} at {RENEWAL * one.start:.1f} s, cable {one.cable + 1}"
                print(f"{where}: {1e3 * one.turned:.1f} mm without it, {told}", flush=True)
            found += stalls
    bounds = ((0.0, REST, "at rest"), (REST, LITTLE, "turning little"), (LITTLE, np.inf, "turning"))
    for least, most, text in bounds:
        own = [one for one in found if least <= one.turned < most]
        print(f"a drum {text}: {len(own)} stalls, {sum(one.told is not None for one in own)} noticed")
    return 0


if __name__ == "__main__":
    sys.exit(main())
