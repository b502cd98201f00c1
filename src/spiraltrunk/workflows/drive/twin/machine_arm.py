"""The simulated arm behind the port of the real ones."""

from __future__ import annotations

from collections import deque
from contextlib import AbstractContextManager, nullcontext
from dataclasses import replace
from typing import final

import numpy as np

from spiraltrunk.control.arm_limits import ArmLimits
from spiraltrunk.control.plant import CONTROL_PERIOD
from spiraltrunk.hardware.arm.arm_port import ArmLoad, ArmState
from spiraltrunk.hardware.arm.checks import ArmSettings
from spiraltrunk.hardware.arm.guarded_arm import GuardedArm
from spiraltrunk.hardware.clock import Clock
from spiraltrunk.hardware.twin.device import TwinDevice
from spiraltrunk.sim.machine import SimMachine
from spiraltrunk.sim.robot.arm import arm_payload

_ROUNDING = 1e-9


@final
class MachineArm(GuardedArm, TwinDevice):
    """MuJoCo's arm, with the checks that a real one gets; it is advanced before the machine.

    Its controller goes from one target to the next on straight ways, as `SimPlant` has it. It compensates housing and
    trunk exactly; `set_load` is checked and kept.
    """

    def __init__(self, machine: SimMachine, clock: Clock, lock: AbstractContextManager[object] | None = None) -> None:
        """The arm of a machine; ``lock`` is held while it is used, where another thread advances it."""
        settings = ArmSettings(
            limits=_complete(machine.arm_limits), payload=arm_payload(machine.design.arm), period=CONTROL_PERIOD,
            position_margin=0.0,
        )  # fmt: skip
        super().__init__(settings, clock)
        self.load: ArmLoad | None = None
        """Load that was set."""
        self._machine = machine
        self._way: deque[np.ndarray] = deque()
        self._wait = 0.0
        self._lock = nullcontext() if lock is None else lock

    def _measure(self) -> ArmState:
        with self._lock:
            position, velocity, acceleration, torque = self._machine.read_arm()
            time = float(self._machine.data.time)
        return ArmState(
            time=time, position=position, velocity=velocity, acceleration=acceleration,
            torque=torque,
        )  # fmt: skip

    def _follow(self, target: np.ndarray) -> None:
        with self._lock:
            self._way = deque(self._machine.interpolate_arm(target))
            self._lead()

    def _halt(self) -> None:
        with self._lock:
            self._way.clear()
            self._machine.hold_arm()

    def advance(self, dt: float) -> None:
        """See `TwinDevice.advance`: the next set point of the way, when it is due."""
        if self._way and self._wait <= _ROUNDING:
            with self._lock:
                self._lead()
        self._wait -= dt

    def _lead(self) -> None:
        self._machine.set_arm(self._way.popleft())
        self._wait = self._machine.arm_period

    def _load(self, load: ArmLoad) -> None:
        self.load = load

    def _release(self) -> None:
        """Nothing is connected."""


def _complete(limits: ArmLimits) -> ArmLimits:
    """The limits with infinite speeds where none are known, as of a user's own MJCF arm."""
    if limits.velocity is not None or limits.position is None:
        return limits
    return replace(limits, velocity=np.full(limits.position[0].shape, np.inf))
