"""Homing of STS servos on the twin, step by step: true lengths against the driver's zero.

Claim (docs/validation/drive.md): the zero is some millimetres beside the straight trunk because the trunk is weak, and
what brakes the servos is not. Both causes are switched off, one after the other, to show their share.
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import replace
from typing import final

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


@final
class Homed:
    """A twin that is homed, and the lengths that its trunk took in at the end of each step."""

    def __init__(self, slack: tuple[float, ...]) -> None:
        drum = size_drum(PAPER)
        motor = replace(STS3215, drum_radius=drum.winding_radius)
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
    stirring.STIR_MOST, sts_models.COMPENSATION = longest, compensation
    for slack in SLACK:
        homed = Homed(slack)
        assert not homed.faults
        rows = (slack, homed.taut, homed.end)
        texts = [" ".join(f"{1e3 * one:6.2f}" for one in row) for row in rows]
        print(f"{name:28}| {texts[0]} | {texts[1]} | {texts[2]} | {homed.time:6.1f}")


def main() -> int:
    """Print the table."""
    argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0]).parse_args()
    print(f"{'':28}| slack before [mm]    | taken in, taut [mm]  | taken in, zero [mm]  | homing [s]")
    longest, compensation = stirring.STIR_MOST, sts_models.COMPENSATION
    show("as it is", longest, compensation)
    show("stirred up to twice as long", 2.0 * longest, compensation)
    show("whole back-EMF compensated", longest, 1.0)
    return 0


if __name__ == "__main__":
    sys.exit(main())
