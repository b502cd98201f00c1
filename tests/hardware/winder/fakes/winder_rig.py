"""A motor with dry friction on a cable: what the winder's control is tried on, apart from the twin's motors."""

from __future__ import annotations

import math
from dataclasses import dataclass

from spiraltrunk.design import presets
from spiraltrunk.design.drum import DrumDesign, size_drum
from spiraltrunk.hardware.motors.motor_port import MotorDataSheet, MotorState
from spiraltrunk.hardware.winder.drum import DrumGeometry
from spiraltrunk.hardware.winder.winder import Winder, WinderReading, WinderState, WinderTarget, build_winder, step

DIRECT = MotorDataSheet(
    name="direct", torque_max=2.22, speed_max=33.5, torque_step=1.4e-4, angle_step=2 * math.pi / 8192, period=1e-3,
    silence_max=0.094, temperature_derate=70.0, temperature_stop=90.0, rotor_inertia=1.3e-4, rotor_friction=0.02,
)  # fmt: skip
"""A motor as GM6020, without a gear."""

GEARED = MotorDataSheet(
    name="geared", torque_max=2.94, speed_max=4.7, torque_step=2.94e-3, angle_step=2 * math.pi / 4096, period=0.01,
    silence_max=0.66, temperature_derate=55.0, temperature_stop=65.0, rotor_inertia=2.4e-3, rotor_friction=0.15,
)  # fmt: skip
"""A motor as STS3215, behind a gear."""

SPOOL = DrumDesign(
    winding_radius=5.5e-3, cable_diameter=1e-3, width=4e-3, travel_in=0.13, travel_out=0.12, dead_turns=1.0
)
"""A maker's spool: 5 mm of core, three turns a layer."""


def build_rig_winder(period: float = 2e-3, motor: MotorDataSheet = DIRECT, stiffness: float = 2e4) -> Winder:
    """The paper's drum on the direct motor, a spool on the geared one."""
    design = size_drum(presets.PAPER) if motor is DIRECT else SPOOL
    return build_winder(presets.PAPER, motor, DrumGeometry(design=design), period, stiffness=stiffness)


@dataclass
class Rig:
    """Rotor, cable and what holds its other end; advanced by the semi-implicit Euler method."""

    winder: Winder
    stiffness: float = 2e4
    """Of the cable to where it is held [N/m]; 0 is a broken cable."""
    slack: float = 0.0
    """Cable to wind in before it is taut [m]."""
    delay: int = 1
    """Periods until a torque acts."""
    is_jammed: bool = False
    """Whether the drum does not turn at all."""
    angle: float = 0.0
    speed: float = 0.0
    tension: float = 0.0
    time: float = 0.0
    friction_scale: float = 1.0
    """Dry friction over what the winder assumes [-]."""
    substeps: int = 20

    def __post_init__(self) -> None:
        self.state = WinderState(zero_angle=0.0)
        self.pending = [0.0] * self.delay
        self.acting = 0.0
        self._pull()

    def _pull(self) -> None:
        wound = self.winder.drum.pull(self.angle)
        self.tension = max(self.stiffness * (wound - self.slack), 0.0)

    def feedback(self) -> MotorState:
        """Angle in steps of the encoder, speed in 1/min, torque as applied."""
        step, rpm = self.winder.angle_step, 2 * math.pi / 60
        return MotorState(
            time=self.time, angle=step * math.floor(self.angle / step), speed=rpm * round(self.speed / rpm),
            torque=self.acting, temperature=30.0,
        )  # fmt: skip

    def advance(self, torque: float) -> None:
        """One period with a torque that acts after the delay."""
        self.pending.append(torque)
        self.acting = self.pending.pop(0)
        dt = self.winder.gains.period / self.substeps
        dry = self.friction_scale * self.winder.friction
        for _ in range(self.substeps):
            driving = self.acting - self.tension * self.winder.drum.radius(self.angle)
            free = self.speed + driving * dt / self.winder.inertia
            rub = dry * dt / self.winder.inertia
            self.speed = 0.0 if self.is_jammed else math.copysign(max(abs(free) - rub, 0.0), free)
            self.angle += self.speed * dt
            self._pull()
        self.time += self.winder.gains.period

    def run(
        self, target: WinderTarget, seconds: float, load_cell: bool = False
    ) -> list[tuple[float, float, WinderReading, float]]:
        """Control for a while; true tension, true pull, reading and torque of each period."""
        seen = []
        for _ in range(round(seconds / self.winder.gains.period)):
            self.state, reading, torque = step(
                self.winder, self.state, target, self.feedback(), self.winder.gains.period,
                measured_tension=self.tension if load_cell else None,
            )  # fmt: skip
            self.advance(torque)
            seen.append((self.tension, self.winder.drum.pull(self.angle), reading, torque))
        return seen
