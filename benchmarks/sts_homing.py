"""Homing of STS servos on the twin, step by step: true lengths against the driver's zero.

Claim (docs/validation/drive.md): the zero is within half a millimetre of the straight trunk, however much the cables
differ in slack, and whether the friction is half or twice what is assumed.
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import replace
from typing import final

import numpy as np

from spiraltrunk.design.drum import size_drum
from spiraltrunk.design.presets import PAPER
from spiraltrunk.hardware.driver.options import DriverOptions
from spiraltrunk.hardware.driver.trunk_driver import TrunkDriver
from spiraltrunk.hardware.motors.sts import models as sts_models
from spiraltrunk.hardware.motors.sts.servos import StsServos, StsSettings
from spiraltrunk.hardware.safety.states import Mode
from spiraltrunk.hardware.safety.watchdog import NoWatchdog
from spiraltrunk.hardware.twin.clock import TwinClock
from spiraltrunk.hardware.twin.sts_bus import MemoryStream, StsTwin
from spiraltrunk.hardware.twin.sts_servo import STS3215, ServoTwin
from spiraltrunk.hardware.twin.trunk.spring_trunk import SpringTrunk
from spiraltrunk.hardware.winder import stirring
from spiraltrunk.hardware.winder.drum import DrumGeometry
from spiraltrunk.hardware.winder.winder import build_winder

PERIOD = 0.01
"""Period of control [s]."""

SLACK = ((0.002, 0.004, 0.006), (0.006, 0.002, 0.001), (0.01, 0.001, 0.001))
"""Slack of the three cables before homing [m]."""

SLACK_MOST = 0.012
"""Largest slack that is drawn [m]."""


@final
class Homed:
    """A twin that is homed, and the lengths that its trunk took in at the end of each step."""

    def __init__(self, slack: tuple[float, ...], friction_scale: float = 1.0) -> None:
        drum = size_drum(PAPER)
        motor = replace(STS3215, drum_radius=drum.winding_radius, friction=friction_scale * STS3215.friction)
        trunk = SpringTrunk(PAPER)
        twin = StsTwin(trunk, [ServoTwin(i, replace(motor, wound=-loose)) for i, loose in enumerate(slack, 1)])
        clock = TwinClock(twin)
        settings = StsSettings(port="memory", servo_ids=(1, 2, 3), directions=(1, 1, 1))
        motors = StsServos.from_settings(settings, clock, stream=MemoryStream(twin))
        winder = build_winder(PAPER, motors.data_sheet, DrumGeometry(design=drum), PERIOD)
        driver = TrunkDriver(
            design=PAPER, motors=motors, winders=[winder] * 3, watchdog=NoWatchdog(), clock=clock,
            options=DriverOptions(period=PERIOD, without_watchdog=True),
        )  # fmt: skip
        self.taut: tuple[float, ...] = ()
        for _ in range(20):
            driver.wait()
            driver.tick()
        driver.home()
        while driver.mode is Mode.HOMING:
            driver.wait()
            driver.tick()
            routine = driver._loop.homing._routine
            if not self.taut and routine._state and routine._state.stirring is not None:
                self.taut = trunk.taken
        self.time, self.faults, self.tensions = clock.now(), driver.faults, tuple(twin.tensions)
        pulls = [cable.pull for cable in driver.snapshot().cables]
        self.end = tuple(taken - pull for taken, pull in zip(trunk.taken, pulls, strict=True))
        """Lengths taken in at the driver's zero [m]."""


def show(name: str, longest: float, compensation: float) -> None:
    """One line for each slack."""
    stirring.STIR_TIME, sts_models.COMPENSATION = longest, compensation
    for slack in SLACK:
        homed = Homed(slack)
        assert not homed.faults
        rows = (slack, homed.taut, homed.end)
        texts = [" ".join(f"{1e3 * one:6.2f}" for one in row) for row in rows]
        print(f"{name:28}| {texts[0]} | {texts[1]} | {texts[2]} | {homed.time:6.1f}")


def main() -> int:
    """Print the table, and the largest errors with slack that is drawn and friction that is not as assumed."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--draws", type=int, default=8, metavar="N", help="drawn slacks for each friction (default 8)")
    parser.add_argument("--seed", type=int, default=0, metavar="N", help="seed of what is drawn (default 0)")
    arguments = parser.parse_args()
    print(f"{'':28}| slack before [mm]    | taken in, taut [mm]  | taken in, zero [mm]  | homing [s]")
    longest, compensation = stirring.STIR_TIME, sts_models.COMPENSATION
    show("as it is", longest, compensation)
    show("stirred twice as long", 2.0 * longest, compensation)
    show("whole back-EMF compensated", longest, 1.0)
    stirring.STIR_TIME, sts_models.COMPENSATION = longest, compensation
    rng = np.random.default_rng(arguments.seed)
    for scale in (0.5, 1.0, 2.0):
        homed = [Homed(tuple(rng.uniform(0.001, SLACK_MOST, 3).tolist()), scale) for _ in range(arguments.draws)]
        errors = [f"{1e3 * max(map(abs, one.end)):.2f}" for one in homed if not one.faults]
        failed = [one.faults[0].text for one in homed if one.faults]
        print(f"friction {scale:g} times the assumed: largest errors {' '.join(errors)} mm; failed: {failed or 'none'}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
