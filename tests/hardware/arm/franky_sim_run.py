"""Drives an FR3 of franky-sim: connect, load, 0.05 rad of joint 4, hold, close; run by `test_franky_sim.py`.

Prints one line of JSON. The server is this process's child, as it and the client stop each other at interpreter exit.
"""

from __future__ import annotations

import json
import subprocess
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[3] / "src"))

import numpy as np

from spiraltrunk.control.arm_limits import ArmLimits
from spiraltrunk.errors import DriveError
from spiraltrunk.hardware.arm.arm_port import ArmLoad
from spiraltrunk.hardware.arm.checks import ArmSettings
from spiraltrunk.hardware.arm.franky_arm import FrankyArm
from spiraltrunk.hardware.clock import SystemClock

ADDRESS = "127.0.0.1"

# Small: franky-sim compensates the weight of a load that its robot does not carry.
LOAD = ArmLoad(mass=0.01, center=np.array([0.0, 0.0, 0.05]), inertia=np.diag([1e-5, 1e-5, 1e-5]))

# FR3, as sim/robot/fr3.py, which needs MuJoCo and meshes that this interpreter may lack.
LOW = np.array([-2.9007, -1.8361, -2.9007, -3.0770, -2.8763, 0.4398, -3.0508])
HIGH = np.array([2.9007, 1.8361, 2.9007, -0.1169, 2.8763, 4.6216, 3.0508])
LIMITS = ArmLimits(
    position=(LOW, HIGH), velocity=np.array([2.62, 2.62, 2.62, 2.62, 5.26, 4.18, 5.26]),
    acceleration=np.full(7, 10.0), jerk=np.full(7, 5000.0), torque=np.array([87.0] * 4 + [12.0] * 3),
    braking=(np.array([0.6599, 0.2517, 0.2000, 0.3533, 0.5757, 0.4878, 0.4628]),
             np.array([6.0, 2.585, 3.5, 4.0, 17.0, 5.5, 17.0])),
)  # fmt: skip


def open_arm(settings: ArmSettings, clock: SystemClock) -> FrankyArm:
    """The arm, once the server listens."""
    for _ in range(60):
        try:
            return FrankyArm(ADDRESS, settings, clock)
        except DriveError:
            time.sleep(0.5)
    return FrankyArm(ADDRESS, settings, clock)


def drive(arm: FrankyArm, clock: SystemClock, period: float) -> dict[str, object]:
    """What was seen."""
    arm.set_load(LOAD)
    start = arm.read()
    moment = clock.now()
    for k in range(1, 101):
        target = start.position.copy()
        target[3] += 0.05 * (1 - np.cos(np.pi * k / 100)) / 2
        arm.send(target)
        moment += period
        clock.sleep_until(moment)
    for _ in range(100):  # The simulated robot is slower than the clock.
        arm.send(target)
        moment += period
        clock.sleep_until(moment)
    moved = arm.read()
    with_jump = target.copy()
    with_jump[0] += 0.5
    try:
        arm.send(with_jump)
        jump = "sent"
    except DriveError as error:
        jump = str(error)
    arm.hold()
    time.sleep(0.5)
    held = arm.read()
    time.sleep(0.5)
    later = arm.read()
    arm.set_load(LOAD)
    arm.close()
    return {
        "errors": [state.error for state in (start, moved, held, later)],
        "moved": (moved.position - start.position).tolist(),
        "drift": float(np.abs(later.position - held.position).max()),
        "jump": jump,
        "fresh": later.time - held.time,
    }


def main() -> None:
    server = subprocess.Popen(
        [sys.executable, "-c", "from franky_sim.run_server import main; main()", "--simulator", "mujoco",
         "--hostname", ADDRESS],
        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
    )  # fmt: skip
    try:
        clock, settings = SystemClock(), ArmSettings(limits=LIMITS, payload=3.0, feedback_age=1.0)
        print(json.dumps(drive(open_arm(settings, clock), clock, settings.period)))
    finally:
        server.kill()
        server.wait()


if __name__ == "__main__":
    main()
