"""The simulated trunk at the other end of the twin motors' cables."""

from __future__ import annotations

from collections.abc import Sequence
from typing import final

import numpy as np

from spiraltrunk.control.plant import CONTROL_PERIOD
from spiraltrunk.errors import DesignError
from spiraltrunk.hardware.twin.cable_load import CableLoad
from spiraltrunk.hardware.twin.clock import STEP
from spiraltrunk.sim.machine import SimMachine
from spiraltrunk.sim.scene.options import EXTREMES_PERIOD

STRONGEST = 10.0
"""Tension at which a simulated cable yields, over the design's largest [-]: far above what any motor pulls."""


@final
class MachineLoad(CableLoad):
    """Advances a simulated machine, whose cables are springs that end on the motors' drums.

    MuJoCo integrates the cables' elasticity implicitly, so that stiff cables need no shorter step. One sample of the
    ground truth is recorded in every control period.

    Args:
        machine: a machine that was restored.

    Raises:
        DesignError: for a scene with another time step than `STEP`, with which the motors' clock ticks.
    """

    def __init__(self, machine: SimMachine) -> None:
        if machine.options.timestep != STEP:
            raise DesignError("scene.timestep", got=machine.options.timestep, allowed=f"{STEP:g} s on the twin")
        self.machine = machine
        self._most = np.full(machine.design.n_cable, STRONGEST * machine.design.cable.tension_max)
        self._steps = 0
        self._is_recording = True

    def begin(self) -> None:
        """Let the scene's time and trace begin anew here, as after homing."""
        self.machine.restart_trace()
        self._steps, self._is_recording = 0, True

    def end(self) -> None:
        """Record no more: the run is over, and what follows is not judged."""
        self._is_recording = False

    def advance(self, wound: Sequence[float], stiffness: Sequence[float], dt: float) -> tuple[float, ...]:
        """Advance by ``dt`` [s], a whole number of the simulation's time steps; tensions at its end [N].

        Raises:
            RunError: where the simulation diverged.
        """
        self.machine.set_cable_stiffness(np.asarray(stiffness, float))
        self.machine.set_cables(self._most, np.asarray(wound, float))
        for _ in range(round(dt / STEP)):
            self._step()
        return tuple(self.machine.read_cable_tension().tolist())

    def _step(self) -> None:
        self.machine.advance(STEP)
        self._steps += 1
        if self._steps % round(EXTREMES_PERIOD / STEP) == 0:
            self.machine.update_extremes()
        if self._is_recording and self._steps % round(CONTROL_PERIOD / STEP) == 0:
            self.machine.record()
