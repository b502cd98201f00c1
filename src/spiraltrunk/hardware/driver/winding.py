"""The winders of all cables as the driver steps them: targets and feedback in, torques and readings out."""

from __future__ import annotations

from collections.abc import Sequence
from typing import final

from spiraltrunk.hardware.driver.targets import Targets
from spiraltrunk.hardware.motors.motor_port import MotorDataSheet, MotorState
from spiraltrunk.hardware.safety.reading import CableRange, CableReading
from spiraltrunk.hardware.safety.watches.motor_watch import derate
from spiraltrunk.hardware.winder.limits import FRICTION_SHARE
from spiraltrunk.hardware.winder.winder import Winder, WinderState, WinderTarget, step

_LEAST_PART = 0.1
"""Least nominal load over the floor of tension [-] (ours), for motors whose friction would leave less."""

STIR_LENGTH = 0.005
"""Cable that another drum moves while one stands, after which that one is stirred [m] (ours)."""

STOOD_LENGTH = 1e-4
"""Cable below which a drum counts as standing meanwhile [m] (ours: more than the stir itself moves)."""


@final
class Winding:
    """Winders of one trunk with their states."""

    def __init__(self, winders: Sequence[Winder], sheet: MotorDataSheet, has_cell: Sequence[bool] = ()) -> None:
        self._winders, self._sheet = tuple(winders), sheet
        self._has_cell = tuple(has_cell) or (False,) * len(self._winders)
        self._zeros = (0.0,) * len(self._winders)
        self._states = self._start()
        self._stood: list[tuple[float, ...]] = []

    @property
    def tension_most(self) -> tuple[float, ...]:
        """Largest tension of each cable that targets may ask for [N]."""
        return tuple(winder.limits.tension_max for winder in self._winders)

    @property
    def tension_floor(self) -> tuple[float, ...]:
        """Floor of tension of each cable [N]."""
        return tuple(winder.limits.tension_floor for winder in self._winders)

    @property
    def floor_torques(self) -> tuple[float, ...]:
        """Torques that hold the floors [N m]."""
        return tuple(winder.limits.tension_floor * winder.drum.radius_max for winder in self._winders)

    def set_zeros(self, zero_angles: tuple[float, ...]) -> None:
        """Take the angles of the motors at the straight trunk [rad] from homing."""
        self._zeros = zero_angles

    def restart(self) -> None:
        """Begin from zero tension, after a time without torque."""
        self._states = self._start()
        self._stood = []

    def _start(self) -> tuple[WinderState, ...]:
        return tuple(WinderState(zero_angle=zero) for zero in self._zeros)

    def compute_pull(self, cable: int, motor: MotorState | None) -> float:
        """Cable wound in since the straight trunk [m]; 0 without feedback."""
        return self._winders[cable].drum.pull(motor.angle - self._zeros[cable]) if motor else 0.0

    @property
    def slack_speed(self) -> float:
        """Speed at which the slowest winder takes in a slack cable [m/s]."""
        return min(winder.gains.slack_speed for winder in self._winders)

    @property
    def lag(self) -> float:
        """Time by which the slowest estimate of a tension lags behind [s]; a load cell does not."""
        pairs = zip(self._winders, self._has_cell, strict=True)
        return max((1.0 / winder.gains.observer for winder, has_cell in pairs if not has_cell), default=0.0)

    def build_ranges(self) -> tuple[CableRange, ...]:
        """What the watches allow each cable."""
        return tuple(map(_build_range, self._winders))

    def step(
        self,
        targets: Targets,
        motors: Sequence[MotorState],
        sent: Sequence[float],
        dt: float,
        *,
        felt: Sequence[float | None] = (),
    ) -> tuple[tuple[CableReading, ...], tuple[float, ...]]:
        """Advance by ``dt`` [s]; a warm motor's tension above the floor is reduced.

        ``felt`` are the tensions by load cells [N], None for a cable without one; empty where there is none at all.

        Raises:
            DriveError: where feedback is no number.
        """
        states, readings, torques = [], [], []
        stirred = self._find_stirred(motors)
        for i, (winder, motor) in enumerate(zip(self._winders, motors, strict=True)):
            target = WinderTarget(tension=self._limit(winder, targets.tension[i], motor), pull=targets.pull[i])
            cell = felt[i] if felt else None
            state, measured, torque = step(
                winder, self._states[i], target, motor, dt, measured_tension=cell, is_stirred=stirred[i]
            )
            states.append(state)
            torques.append(torque)
            readings.append(
                CableReading(
                    motor=motor,
                    torque=sent[i],
                    pull=measured.pull,
                    speed=measured.speed,
                    tension=measured.tension,
                    felt=cell,
                    estimated=None if cell is None else state.tension,
                    is_loss_most=measured.is_loss_most,
                    pull_at_tension=None if cell is not None else state.slow_pull,
                    resistance=state.resistance,
                    tension_wanted=state.tension_set,
                    is_stirred=state.dither.stir > 0.0,
                )
            )
        self._states = tuple(states)
        return tuple(readings), tuple(torques)

    def _find_stirred(self, motors: Sequence[MotorState]) -> list[bool]:
        """Which drums have stood while another one moved by `STIR_LENGTH` since they were stirred last.

        The others bend the trunk, and a stuck drum would bend it another way than it was told to: see `winder.dither`.
        Only a taut cable above the floor of tension is stirred. A drum at the floor that a stir lets go takes in slack
        at once, which looks like a slip.
        """
        pulls = tuple(self.compute_pull(i, motor) for i, motor in enumerate(motors))
        self._stood = self._stood or [pulls] * len(pulls)
        stirred = []
        for i, before in enumerate(self._stood):
            moved = [abs(now - then) for now, then in zip(pulls, before, strict=True)]
            is_standing = moved[i] < STOOD_LENGTH
            stirred.append(is_standing and max(moved) > STIR_LENGTH and _is_taut(self._winders[i], self._states[i]))
            if stirred[i] or not is_standing:
                self._stood[i] = pulls
        return stirred

    def _limit(self, winder: Winder, tension: float, motor: MotorState) -> float:
        """Tension that a motor of this temperature may have [N]."""
        floor, ceiling = winder.limits.tension_floor, winder.limits.tension_ceiling
        return min(tension, floor + derate(motor.temperature, self._sheet) * max(0.0, ceiling - floor))


def _is_taut(winder: Winder, state: WinderState) -> bool:
    """Whether a cable is set to more than the floor and the dry friction, and carries half of it at least."""
    least = winder.limits.tension_floor + winder.friction / winder.drum.design.winding_radius
    return state.tension_set > least and state.tension > 0.5 * state.tension_set


def _build_range(winder: Winder) -> CableRange:
    """What the watches allow one cable."""
    limits = winder.limits
    friction = winder.friction / winder.drum.design.winding_radius
    loss = (1.0 - FRICTION_SHARE) * friction
    return CableRange(
        tension_least=max(limits.tension_floor - loss, _LEAST_PART * limits.tension_floor),
        tension_ceiling=limits.tension_ceiling,
        pull_least=limits.pull_min,
        pull_most=limits.pull_max,
        drag=limits.drag,
        friction=friction,
    )
