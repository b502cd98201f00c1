"""The simulated arm behind the port of the real ones."""

from __future__ import annotations

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
from spiraltrunk.sim.machine import SimMachine
from spiraltrunk.sim.robot.arm import arm_payload


@final
class MachineArm(GuardedArm):
    """MuJoCo's arm, with the checks that a real one gets.

    Its controller compensates housing and trunk exactly, as `SimMachine` has it; `set_load` is checked and kept.
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
            self._machine.set_arm(target)

    def _halt(self) -> None:
        with self._lock:
            self._machine.hold_arm()

    def _load(self, load: ArmLoad) -> None:
        self.load = load

    def _release(self) -> None:
        """Nothing is connected."""


def _complete(limits: ArmLimits) -> ArmLimits:
    """The limits with infinite speeds where none are known, as of a user's own MJCF arm."""
    if limits.velocity is not None or limits.position is None:
        return limits
    return replace(limits, velocity=np.full(limits.position[0].shape, np.inf))
