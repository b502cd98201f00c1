"""STS servos that are known: their data sheets, and the law between duty cycle, speed and torque."""

from __future__ import annotations

import math
from typing import NamedTuple, final

from spiraltrunk.hardware.motors.motor_port import MotorDataSheet
from spiraltrunk.hardware.motors.sts import codec

SPEED_MARGIN = 1.5
"""Largest believed speed over the nominal one [-] (ours): `VOLTAGE_MOST`, and 1.25 because the time of a measurement is
known to a few milliseconds only; frames that were recorded at 12.2 V tell up to 1.06."""
COMPENSATION = 0.9
"""Part of the back-EMF that a commanded torque compensates [-] (ours): below 1, so that an error of the nominal speed
drives no motor on by itself."""
VOLTAGE_LEAST, VOLTAGE_MOST = 0.8, 1.2
"""Least and largest supply that is accepted, over the nominal one [-] (ours): the variants' ranges do not overlap."""
KGF_CM = 0.0980665
"""One kilogram-force at one centimetre [N m]."""


@final
class StsModel(NamedTuple):
    """One variant of a servo: its limits and what it is recognised by."""

    data_sheet: MotorDataSheet
    """Limits; ``torque_max`` is the stall torque, which the servo's own protection allows for seconds only."""
    voltage: float
    """Nominal supply voltage [V]."""
    number: int
    """Model number that a servo answers; the variants for 7.4 V and 12 V share it (unconfirmed)."""

    @property
    def voltage_range(self) -> tuple[float, float]:
        """Least and largest supply [V]: `VOLTAGE_LEAST` and `VOLTAGE_MOST` of the nominal one."""
        return round(VOLTAGE_LEAST * self.voltage, 2), round(VOLTAGE_MOST * self.voltage, 2)


def _build_sheet(name: str, stall_kgf_cm: float, speed_max_rpm: float) -> MotorDataSheet:
    """Data sheet of an STS3215.

    Stall torque and speed are the manufacturer's. A test bench found 35 kgf cm and 46 rpm at 12 V, and a cut-off at
    70 degC (robonine.com, "Testing of Feetech STS3215"). Inertia and friction have no source (ours): a rotor of
    2e-8 kg m^2 behind 1:345, and gears that a few newtons at the horn do not turn. Measure both.
    """
    speed_max = speed_max_rpm * 2.0 * math.pi / 60.0
    return MotorDataSheet(
        name=name,
        torque_max=stall_kgf_cm * KGF_CM,
        speed_max=speed_max,
        torque_step=stall_kgf_cm * KGF_CM / codec.DUTY_MAX,
        angle_step=codec.STEP,
        period=0.01,
        silence_max=math.pi / (SPEED_MARGIN * speed_max),
        temperature_derate=55.0,
        temperature_stop=65.0,
        rotor_inertia=2.4e-3,
        rotor_friction=0.15,
    )


MODELS = {
    "sts3215-12v": StsModel(_build_sheet("sts3215-12v", 30.0, 45.0), 12.0, 777),
    "sts3215-7v4": StsModel(_build_sheet("sts3215-7v4", 19.5, 52.0), 7.4, 777),
}
"""Known servos by name; 777 as in LeRobot's table of Feetech's models."""


def estimate_torque(model: StsModel, duty: float, speed: float, voltage: float) -> float:
    """Torque of a servo's motor before the friction of its gears [N m].

    A DC motor's law, ``torque = stall_torque * (duty * V / V_nominal - speed / speed_max)``, limited to the stall
    torque. Unconfirmed: no servo was measured.

    Args:
        model: the servo.
        duty: duty cycle, -1 to 1 [-].
        speed: speed [rad/s].
        voltage: supply [V].
    """
    share = duty * voltage / model.voltage - speed / model.data_sheet.speed_max
    return model.data_sheet.torque_max * max(-1.0, min(1.0, share))


def compute_duty(model: StsModel, torque: float, speed: float, voltage: float) -> float:
    """Duty cycle, -1 to 1, that gives a torque [N m]: the inverse of `estimate_torque`, but for `COMPENSATION` [-].

    Without the speed's part the back-EMF would brake a winder to a few millimetres per second. With a part of up to 1
    of a speed that was measured a time d ago, the rotor ``J w' = t - b (w(t) - c w(t - d))`` stays stable for any d:
    where Re s > 0, ``|J s + b| > b >= |c b exp(-s d)|``, so that no such s is a root.
    """
    share = torque / model.data_sheet.torque_max + COMPENSATION * speed / model.data_sheet.speed_max
    return max(-1.0, min(1.0, share * model.voltage / voltage))
