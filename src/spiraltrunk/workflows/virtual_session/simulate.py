"""A run of the protocol on a printed trunk: by simulation in MuJoCo, or by the equilibrium model."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import final

import numpy as np

from spiraltrunk.calibration.predict_states import State, predict_statics
from spiraltrunk.errors import ModelError
from spiraltrunk.mocap.protocol.schedule import Schedule
from spiraltrunk.model.kinematics.frames import base_orientation, section_frames
from spiraltrunk.model.kinematics.shape import Shape, Status
from spiraltrunk.sim.relaxation.relax import LoadStep, RelaxationOptions, RelaxationRig
from spiraltrunk.sim.robot.trunk import TrunkOptions, hinge_names
from spiraltrunk.workflows.virtual_session.printed_trunk import PrintedTrunk

RELAXATION = RelaxationOptions(
    has_gripper=False, pull_speed=0.005, has_smooth_ramps=True, still=2e-3, time_most=10.0, limit_factor=10.0,
    armature_factor=10.0, trunk=TrunkOptions(hole_set_back=0.001),
)  # fmt: skip
"""Relaxation of the simulated trunk: smooth winder ramps at 5 mm/s, holes set back by a thousandth of the face only,
joint limits ten times as stiff as in grasps; a shape is held when no joint moves faster than 2 mrad/s."""


@final
@dataclass(frozen=True, kw_only=True)
class SimulatedRun:
    """The shapes of one run."""

    schedule: Schedule
    """The winders' lengths."""
    ends: np.ndarray
    """Section ends, shape (n, n_section, 3) [m]."""
    rotation: np.ndarray
    """Axes of the sections, shape (n, n_section, 3, 3) [-]."""
    unsettled: int
    """Number of shapes in which the trunk did not come to rest [-]."""


def simulate_run(trunk: PrintedTrunk, schedule: Schedule, options: RelaxationOptions = RELAXATION) -> SimulatedRun:
    """A run in MuJoCo, with friction, joint limits, weight, inertia and the motion from shape to shape.

    Raises:
        ModelError: where the trunk has other cables than the schedule.
    """
    _check_cables(trunk, schedule)
    stiff = replace(options.trunk, cable_gain=1 / trunk.winders.compliance)
    rig = RelaxationRig(trunk.design, theta_0=schedule.run.theta_0, options=replace(options, trunk=stiff))
    for i, sag in enumerate(trunk.sag):
        for name, angle in zip(hinge_names(i), sag, strict=True):
            rig.model.qpos_spring[rig.model.joint(name).qposadr[0]] = angle
    if schedule.run.kind == "rest":
        return _build_run(trunk, schedule, [rig.relax().shape])
    _, *loaded = rig.iterate([LoadStep(pull=length - trunk.winders.slack) for length in schedule.pull])
    return _build_run(trunk, schedule, [relaxed.shape for relaxed in loaded])


def solve_run(trunk: PrintedTrunk, schedule: Schedule) -> SimulatedRun:
    """A run by the model that calibration fits: a thousand times as fast, without model error or sag.

    Raises:
        ModelError: where the trunk has other cables than the schedule, or sags.
    """
    _check_cables(trunk, schedule)
    if trunk.sag.any():
        raise ModelError("the trunk sags; allowed with the equilibrium model: a sag of 0")
    states = tuple(
        State(theta_0=schedule.run.theta_0, pull=tuple(pull), before=i - 1, kind=schedule.run.kind, chain=0)
        for i, pull in enumerate(schedule.pull.tolist())
    )
    return _build_run(trunk, schedule, list(predict_statics(trunk.design, states, trunk.winders).shapes))


def _check_cables(trunk: PrintedTrunk, schedule: Schedule) -> None:
    if schedule.pull.shape[1] != trunk.design.n_cable:
        cables = f"{schedule.pull.shape[1]} cables, the trunk {trunk.design.n_cable}"
        raise ModelError(f"the schedule has {cables}; allowed: a schedule of the same trunk")


def _build_run(trunk: PrintedTrunk, schedule: Schedule, shapes: list[Shape]) -> SimulatedRun:
    rotations = np.stack([shape.joint_rotation for shape in shapes])
    frames = base_orientation(schedule.run.theta_0) @ section_frames(trunk.design, rotations)[..., :3, :3]
    return SimulatedRun(
        schedule=schedule, ends=np.stack([shape.points for shape in shapes]), rotation=frames,
        unsettled=sum(int(shape.status) == Status.NOT_CONVERGED for shape in shapes),
    )  # fmt: skip
