"""How much faster than real time the twin of three motors and the trunk runs, on one core.

Claim: 15 times real time or more, with 1 ms steps, feedback and commands at 500 Hz over the bus in memory, without a
driver. Processor time is measured, so that other programs on the core do not count.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
import time

from spiraltrunk.design.presets import PAPER
from spiraltrunk.hardware.bus.frame_bus import Frame
from spiraltrunk.hardware.bus.memory_bus import build_memory_pair
from spiraltrunk.hardware.motors.gm6020 import TORQUE_PER_RAW, CommandMode, encode_command
from spiraltrunk.hardware.twin.clock import TwinClock
from spiraltrunk.hardware.twin.motor import MotorParameters, MotorTwin
from spiraltrunk.hardware.twin.motors import MotorTwins
from spiraltrunk.hardware.twin.trunk.spring_trunk import SpringTrunk

BAR = 15.0
"""Simulated seconds per second of processor time that are claimed."""

PERIOD = 2e-3
"""Period of commands and feedback [s]."""


def run(duration: float) -> dict[str, float | int | bool]:
    """Move the trunk round for this long [s], and measure."""
    clock = TwinClock()
    driver, device = build_memory_pair(clock)
    motors = [MotorTwin(MotorParameters()) for _ in range(PAPER.n_cable)]
    twins = MotorTwins(device, SpringTrunk(PAPER), motors, feedback_period=PERIOD)
    clock.attach(twins)
    frames, start = 0, time.process_time()
    for k in range(round(duration / PERIOD)):
        torques = [0.2 + 0.15 * math.sin(0.01 * k + angle) for angle in PAPER.cable.angles]
        values = [round(torque / TORQUE_PER_RAW) for torque in torques] + [0] * (4 - len(torques))
        driver.send(Frame(CommandMode.CURRENT.value, encode_command(values, CommandMode.CURRENT)))
        driver.flush()
        clock.sleep_until((k + 1) * PERIOD)
        frames += len(driver.receive())
    spent = time.process_time() - start
    factor = duration / spent
    return {"simulated_s": duration, "cpu_s": round(spent, 2), "factor": round(factor, 1), "bar": BAR,
            "frames": frames, "holds": factor >= BAR}  # fmt: skip


def main() -> int:
    """Print the figures; 1 where the claim does not hold."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=100.0, help="simulated time [s]")
    figures = run(parser.parse_args().seconds)
    print(json.dumps(figures))
    return 0 if figures["holds"] else 1


if __name__ == "__main__":
    sys.exit(main())
