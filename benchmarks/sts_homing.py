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
from spiraltrunk.hardware.winder import homing
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
            if not self.taut and routine._state and routine._state.taut_since <= routine._state.time:
                self.taut = trunk.taken
        self.end, self.tensions, self.faults = trunk.taken, tuple(twin.tensions), driver.faults
        """Lengths at the driver's zero [m], and tensions [N]."""


def show(name: str, stir: float, compensation: float) -> None:
    """One line for each slack."""
    homing.STIR_TIME, sts_models.COMPENSATION = stir, compensation
    for slack in SLACK:
        homed = Homed(slack)
        assert not homed.faults
        rows = (slack, homed.taut, homed.end)
        texts = [" ".join(f"{1e3 * one:6.2f}" for one in row) for row in rows]
        tensions = " ".join(f"{one:6.2f}" for one in homed.tensions)
        print(f"{name:28}| {texts[0]} | {texts[1]} | {texts[2]} | {tensions}")


def main() -> int:
    """Print the table."""
    argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0]).parse_args()
    print(f"{'':28}| slack before [mm]    | taken in, taut [mm]  | taken in, zero [mm]  | tension at zero [N]")
    stir, compensation = homing.STIR_TIME, sts_models.COMPENSATION
    show("as it is", stir, compensation)
    show("stirred four times as long", 4.0 * stir, compensation)
    show("whole back-EMF compensated", stir, 1.0)
    show("both", 4.0 * stir, 1.0)
    return 0


if __name__ == "__main__":
    sys.exit(main())
