"""Dynamics of one motor with its drum: rotor, dry friction, current, temperature, encoder."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import final

from spiraltrunk.checks import check_number
from spiraltrunk.errors import DesignError
from spiraltrunk.field_docs import explain_fields
from spiraltrunk.hardware.motors.gm6020 import CURRENT_MAX, GM6020, STEPS, TORQUE_CONSTANT


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class MotorParameters:
    """Numbers of one motor and its drum; the defaults are a GM6020, none of them measured on one."""

    rotor_inertia: float = GM6020.rotor_inertia
    """Inertia of rotor and drum [kg m^2] (ours: the maker publishes none)."""
    friction: float = GM6020.rotor_friction
    """Dry friction of bearings and cogging [N m] (ours)."""
    torque_constant: float = TORQUE_CONSTANT
    """Torque per current [N m/A] (GM6020 user guide)."""
    current_max: float = CURRENT_MAX
    """Largest current [A] (see `motors.gm6020`)."""
    current_time: float = 1e-3
    """Time constant of the current loop [s] (ours)."""
    supply: float = 24.0
    """Supply voltage [V]."""
    speed_free: float = GM6020.speed_max
    """Speed without load at 24 V [rad/s] (GM6020 user guide: 320 rpm); sets the back-EMF."""
    resistance: float = 8.0
    """Resistance of the winding [Ohm] (ours: 24 V drive 3 A through it at standstill)."""
    thermal_resistance: float = 3.0
    """Heating of the winding per power in steady state [K/W] (ours: 88 degC at 1.62 A and 25 degC around it)."""
    thermal_time: float = 400.0
    """Time constant of the winding's temperature [s] (ours)."""
    ambient: float = 25.0
    """Temperature around the motor [degC]."""
    encoder_counts: int = STEPS
    """Counts of the encoder in a turn [-] (GM6020: 13 bits)."""
    encoder_start: int = 0
    """Count at the start of the twin [-]."""
    drum_radius: float = 0.01
    """Radius of the wound cable's centre line [m] (ours: about that of the paper's trunk)."""
    cable_stiffness: float = 2e4
    """Tension per elongation of cable and winder [N/m] (ours)."""
    wound: float = 0.0
    """Cable on the drum at the start, beyond that of the straight, just taut trunk [m]."""
    is_reversed: bool = False
    """Whether the drum winds the cable in when the motor turns backwards."""

    def __post_init__(self) -> None:
        for name in ("rotor_inertia", "torque_constant", "current_max", "current_time", "resistance", "supply"):
            check_number(name, getattr(self, name), least=1e-6, most=1e4)
        for name in ("speed_free", "thermal_resistance", "thermal_time"):
            check_number(name, getattr(self, name), least=1e-6, most=1e6)
        check_number("friction", self.friction, least=0.0, most=1e3)
        check_number("ambient", self.ambient, least=-40.0, most=150.0)
        check_number("drum_radius", self.drum_radius, least=1e-3, most=1.0)
        check_number("cable_stiffness", self.cable_stiffness, least=0.0, most=1e7)
        check_number("wound", self.wound, least=-10.0, most=10.0)
        check_number("encoder_counts", self.encoder_counts, least=2, most=2**24)
        if not 0 <= self.encoder_start < self.encoder_counts:
            raise DesignError("encoder_start", got=self.encoder_start, allowed=f"0 to {self.encoder_counts - 1}")

    @property
    def back_emf(self) -> float:
        """Voltage per speed k_e [V s/rad], with which 24 V are used up at the speed without load."""
        return 24.0 / self.speed_free


@final
class MotorTwin:
    """State of one motor with its drum and cable; positive is winding in.

    Current loop (first order, exact over a step), torque and rotor (semi-implicit Euler):

        di/dt = (clip(i_command, (-U - k_e w) / R, (U - k_e w) / R) - i) / tau
        J dw/dt = k_t i - r T - friction,  friction at most its largest torque, and at rest whatever keeps it at rest
        dwound/dt = r w,   C dtheta/dt = R i^2 - (theta - ambient) / R_th

    Friction is applied as an impulse that ends at standstill, so that a motor sticks and does not creep.
    """

    __slots__ = (
        "_accelerate", "_blend", "_dt", "_heat", "_high", "_p", "_per_rad", "_rub", "_slope", "_warm", "angle",
        "command", "current", "encoder_offset", "heating", "is_blocked", "is_on", "lever", "speed",
        "stiffness", "temperature", "wound",
    )  # fmt: skip

    def __init__(self, parameters: MotorParameters) -> None:
        """A cold motor at rest without a command."""
        p = self._p = parameters
        self.command = 0.0
        """Commanded current [A]."""
        self.current = 0.0
        """Current in the winding [A]."""
        self.speed = 0.0
        """Speed [rad/s]."""
        self.angle = 0.0
        """Angle turned since the start [rad]."""
        self.wound = p.wound
        """Cable on the drum beyond that of the straight, just taut trunk [m]."""
        self.temperature = p.ambient
        """Temperature of the winding [degC]."""
        self.encoder_offset = float(p.encoder_start)
        """Count of the encoder at angle 0 [-]."""
        self.is_blocked = False
        """Whether something holds the rotor."""
        self.is_on = True
        """Whether it has its supply: without it there is neither torque nor feedback."""
        self.lever = p.drum_radius
        """Cable wound per angle [m/rad]: the drum's radius, negative while it winds the wrong way."""
        self.stiffness = p.cable_stiffness
        """Stiffness of cable and winder [N/m]; 0 when broken."""
        self.heating = 0.0
        """Heating by something else than the current [K/s]."""
        self._slope, self._high = p.back_emf / p.resistance, p.supply / p.resistance
        self._per_rad = self.direction * p.encoder_counts / math.tau
        self._dt = 0.0

    @property
    def parameters(self) -> MotorParameters:
        """Numbers of the motor."""
        return self._p

    @property
    def direction(self) -> float:
        """1 where the motor's positive sense winds in, -1 where it pays out [-]."""
        return -1.0 if self._p.is_reversed else 1.0

    @property
    def count(self) -> int:
        """Reading of the encoder within a turn [-]."""
        return self.read_count(0.0)

    def read_count(self, error: float) -> int:
        """Reading of the encoder within a turn, with this error in counts [-]."""
        return math.floor(self.encoder_offset + self.angle * self._per_rad + error) % self._p.encoder_counts

    @property
    def torque(self) -> float:
        """Electric torque [N m]."""
        return self._p.torque_constant * self.current

    def advance(self, tension: float, dt: float) -> None:
        """Advance by ``dt`` [s] under this tension of its cable [N]."""
        if dt != self._dt:
            self._prepare(dt)
        speed, most = self.speed, self._p.current_max
        back = self._slope * speed
        target = min(max(self.command, -most, -self._high - back), most, self._high - back)
        current = self.current = self.current + self._blend * (target - self.current)
        speed += self._accelerate * (self._p.torque_constant * current - self.lever * tension)
        rub = self._rub
        if self.is_blocked or -rub <= speed <= rub:
            self.speed = 0.0
        else:
            self.speed = speed = speed - rub if speed > 0.0 else speed + rub
            turned = speed * dt
            self.angle += turned
            self.wound += self.lever * turned
        heat = self._heat * current * current + self.heating * dt
        self.temperature += heat - self._warm * (self.temperature - self._p.ambient)

    def _prepare(self, dt: float) -> None:
        """Factors that depend on the step alone."""
        p, self._dt = self._p, dt
        self._blend = -math.expm1(-dt / p.current_time)
        self._accelerate = dt / p.rotor_inertia
        self._rub = dt * p.friction / p.rotor_inertia
        self._warm = -math.expm1(-dt / p.thermal_time)
        self._heat = self._warm * p.thermal_resistance * p.resistance
