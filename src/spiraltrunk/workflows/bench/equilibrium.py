"""Equilibrium under cables and loads against relaxation of the same trunk in MuJoCo."""

from __future__ import annotations

import math
import statistics
from dataclasses import dataclass
from typing import final

import numpy as np

from spiraltrunk.design import presets
from spiraltrunk.model import statics
from spiraltrunk.model.kinematics.shape import Shape
from spiraltrunk.sim.relaxation.relax import LoadStep, RelaxationOptions, RelaxationRig
from spiraltrunk.sim.robot.trunk import TrunkOptions
from spiraltrunk.workflows.bench.claim import Claim, time_in_turns

COUNT = 20
"""Cases; the median ratio counts."""

TUNED = RelaxationOptions(
    timestep=8e-3, damping_factor=8.0, armature_factor=100.0, still=2e-3, pull_speed=math.inf, tension_speed=math.inf,
    has_gripper=False,
)  # fmt: skip
"""Options with which MuJoCo reaches its final shape within 0.5 mm in the least wall time.

The best of a grid of steps (1 to 8 ms), damping (4 and 8 times the design's), armature (1 to 100 times) and speeds of
rest. It favours MuJoCo: joint limits are soft at that step, and shapes at the limits are up to 15 mm off.
"""

SAME = statics.StaticsOptions(
    has_hinges=True, hole_set_back=TrunkOptions().hole_set_back, cable_stiffness=TrunkOptions().cable_gain
)
"""The simulated trunk: two hinges per joint, holes set back, compliant winders."""


@final
@dataclass(frozen=True, kw_only=True)
class Case:
    """One random loading."""

    pull: np.ndarray
    """Cable pulled in; 0 for a slack cable, shape (n_cable,) [m]."""
    tilt: float
    """Angle of the base axis below the horizontal [rad]."""
    load: float
    """Mass at the end of a section [kg]."""
    section: int
    """That section."""

    def solve(self) -> Shape:
        """Our equilibrium."""
        loads = statics.Loads(mass=self.load, section=self.section)
        return statics.solve(
            presets.PAPER, pull=self.pull, by_tension=self.pull == 0, theta_0=self.tilt, loads=loads, friction=0.0,
            options=SAME,
        )  # fmt: skip

    def build_rig(self, options: RelaxationOptions) -> RelaxationRig:
        """MuJoCo's trunk without gripper, as ours."""
        loads = np.zeros(presets.PAPER.n_section)
        loads[self.section] = self.load
        return RelaxationRig(presets.PAPER, theta_0=self.tilt, loads=loads, options=options)

    @property
    def load_step(self) -> LoadStep:
        """Commands of the winders."""
        return LoadStep(pull=np.where(self.pull == 0, math.nan, self.pull))


def draw_cases(seed: int = 0) -> list[Case]:
    """One or two cables pulled by 20 to 80 mm, up to 50 g at any section, from hanging to horizontal."""
    rng = np.random.default_rng(seed)
    cases = []
    for _ in range(COUNT):
        pull = np.zeros(presets.PAPER.n_cable)
        pulled = rng.permutation(presets.PAPER.n_cable)[: rng.integers(1, 3)]
        pull[pulled] = rng.uniform(0.02, 0.08, len(pulled))
        tilt, load = float(rng.uniform(0.0, math.pi / 2)), float(rng.uniform(0.0, 0.05))
        cases.append(Case(pull=pull, tilt=tilt, load=load, section=int(rng.integers(presets.PAPER.n_section))))
    return cases


def measure_statics_mujoco() -> Claim:
    """An equilibrium under one or two pulled cables and a load against MuJoCo's, relaxed with tuned damping [s].

    The times are those of the case with the median ratio. MuJoCo's starts at rest under gravity, which is not counted.
    """
    timed = sorted((time_case(case) for case in draw_cases()), key=lambda pair: pair[1] / pair[0])
    ours, other = timed[statistics.median_low(range(len(timed)))]
    return Claim(ours=ours, other=other, bar=10.0)


def time_case(case: Case) -> tuple[float, float]:
    """Wall time of our equilibrium and of MuJoCo's [s]."""
    rig = case.build_rig(TUNED)
    ours, both, rest = time_in_turns(case.solve, lambda: rig.relax([case.load_step]), rig.relax, turns=3, span=0.1)
    return ours, both - rest
