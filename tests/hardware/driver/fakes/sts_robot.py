"""Three STS servos in simulated time, behind the driver."""

from __future__ import annotations

from contextlib import nullcontext
from dataclasses import replace

from prepared import prepare_once

from spiraltrunk.design.drum import size_drum
from spiraltrunk.design.presets import PAPER
from spiraltrunk.hardware.driver.options import DriverOptions
from spiraltrunk.hardware.driver.trunk_driver import TrunkDriver
from spiraltrunk.hardware.motors.load_cell import LoadCells, LoadCellSettings
from spiraltrunk.hardware.motors.sts.servos import StsServos, StsSettings
from spiraltrunk.hardware.safety.states import Mode
from spiraltrunk.hardware.safety.watchdog import NoWatchdog
from spiraltrunk.hardware.twin.clock import TwinClock
from spiraltrunk.hardware.twin.device import TwinDevice
from spiraltrunk.hardware.twin.load_cells import LoadCellTwin
from spiraltrunk.hardware.twin.sts_bus import MemoryStream, PseudoTerminal, StsTwin
from spiraltrunk.hardware.twin.sts_servo import STS3215, ServoTwin
from spiraltrunk.hardware.twin.trunk.spring_trunk import SpringTrunk
from spiraltrunk.hardware.winder.drum import DrumGeometry
from spiraltrunk.hardware.winder.winder import build_winder

PERIOD = 0.01


class Line(TwinDevice):
    """Serves the pseudo-terminal in simulated time."""

    def __init__(self, terminal: PseudoTerminal) -> None:
        self.terminal = terminal

    def advance(self, dt: float) -> None:
        self.terminal.serve()


class Robot:
    """Three servos in simulated time; with a terminal, the operating system carries their bytes."""

    def __init__(
        self, encoder_start: int = 1000, *, has_terminal: bool = False, cells: LoadCellSettings | None = None
    ) -> None:
        self.key = None if has_terminal else ("sts", encoder_start, cells)
        drum = size_drum(PAPER)
        motor = replace(STS3215, drum_radius=drum.winding_radius, encoder_start=encoder_start)
        servos = [ServoTwin(i, replace(motor, wound=-0.002 * i)) for i in (1, 2, 3)]
        self.twin = StsTwin(SpringTrunk(PAPER), servos)
        self.clock = TwinClock()
        self.terminal = PseudoTerminal(self.twin) if has_terminal else None
        motors = self._open_terminal(self.terminal) if self.terminal else self._open_memory()
        self.clock.attach(self.twin)
        if cells is not None:
            self.twin.cells = LoadCellTwin(cells, lambda: self.twin.tensions)
            self.clock.attach(self.twin.cells)
        winder = build_winder(PAPER, motors.data_sheet, DrumGeometry(design=drum), PERIOD)
        options = DriverOptions(period=PERIOD, without_watchdog=True)
        self.driver = TrunkDriver(
            design=PAPER, motors=motors, winders=[winder] * 3, watchdog=NoWatchdog(), clock=self.clock,
            options=options,
            load_cells=None if cells is None else LoadCells(cells, self.twin.cells, self.clock),
        )  # fmt: skip

    def _open_terminal(self, terminal: PseudoTerminal) -> StsServos:
        with terminal.serving() as port:
            settings = StsSettings(port=port, servo_ids=(1, 2, 3), directions=(1, 1, 1))
            motors = StsServos.from_settings(settings, self.clock)
        self.clock.attach(Line(terminal))
        return motors

    def _open_memory(self) -> StsServos:
        settings = StsSettings(port="memory", servo_ids=(1, 2, 3), directions=(1, 1, 1))
        return StsServos.from_settings(settings, self.clock, stream=MemoryStream(self.twin))

    def close(self) -> None:
        with self.terminal.serving() if self.terminal else nullcontext():
            self.driver.close()
        if self.terminal:
            self.terminal.close()

    def run(self, seconds: float, tension: tuple[float, ...] | None = None) -> None:
        end = self.clock.now() + seconds
        while self.clock.now() < end:
            if tension is not None and self.driver.mode is Mode.ARMED:
                self.driver.set_targets(tension, valid_for=0.05)
            self.driver.wait()
            self.driver.tick()

    def prepare(self) -> None:
        """Home and arm, or become a copy of a robot as this one that was."""
        if self.key is None:
            self._prepare()
        else:
            prepare_once(self, self.key, self._prepare)

    def _prepare(self) -> None:
        self.run(0.2)
        self.driver.home()
        end = self.clock.now() + 60.0
        while self.driver.mode is Mode.HOMING and self.clock.now() < end:
            self.run(0.1)
        assert self.driver.faults == ()
        self.driver.arm()

    def is_off(self) -> bool:
        """Whether no servo is driven; one whose cable turns it still brakes."""
        return all(servo.duty == 0 for servo in self.twin.servos)
