"""The protocol played on a trunk: by moving it in MuJoCo, or, a thousand times as fast, by the equilibrium model."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from spiraltrunk.calibration.predict_states import State, predict_statics
from spiraltrunk.errors import ModelError
from spiraltrunk.mocap.protocol.schedule import Plan
from spiraltrunk.model.kinematics.frames import base_orientation, section_frames
from spiraltrunk.model.kinematics.shape import Shape, Status
from spiraltrunk.sim.relaxation.relax import Settled, SettleOptions, SettleRig, Stage
from spiraltrunk.sim.robot.trunk import TrunkOptions, hinge_names
from spiraltrunk.workflows.virtual_session.printed_trunk import World

SETTLE = SettleOptions(
    has_gripper=False, pull_speed=0.005, has_smooth_ramps=True, still=2e-3, time_most=10.0, limit_factor=10.0,
    armature_factor=10.0, trunk=TrunkOptions(hole_set_back=0.001),
)  # fmt: skip
"""How the trunk is played: winders that start and stop softly and pull at 5 mm/s, holes where they were designed but
for a thousandth of the face, faces ten times as hard as in the grasps; a shape is held when no joint turns faster than
2 mrad/s. Winders give as the world's do."""


@final
@dataclass(frozen=True, kw_only=True)
class Played:
    """The shapes of one run."""

    plan: Plan
    """What was done."""
    ends: np.ndarray
    """Section ends, shape (n, n_section, 3) [m]."""
    rotation: np.ndarray
    """Axes of the sections, shape (n, n_section, 3, 3) [-]."""
    unsettled: int
    """Shapes in which the trunk did not come to rest [-]."""


def play_simulated(world: World, plan: Plan, options: SettleOptions = SETTLE) -> Played:
    """A run in MuJoCo: friction, faces, weight and inertia, the way from shape to shape included.

    Raises:
        ModelError: where the world has other cables than the plan.
    """
    _check(world, plan)
    trunk = replace(options.trunk, cable_gain=1 / world.winders.compliance)
    rig = SettleRig(world.design, theta_0=plan.run.theta_0, options=replace(options, trunk=trunk))
    for i, sag in enumerate(world.sag):
        for name, angle in zip(hinge_names(i), sag, strict=True):
            rig.model.qpos_spring[rig.model.joint(name).qposadr[0]] = angle
    return _collect(world, plan, [settled.shape for settled in _visit(rig, world, plan)])


def play_by_model(world: World, plan: Plan) -> Played:
    """A run by the model that calibration fits: no error of the model, and no sag, which it does not know.

    Raises:
        ModelError: where the world has other cables than the plan, or sags.
    """
    _check(world, plan)
    if world.sag.any():
        raise ModelError("the world sags; allowed with the equilibrium model: a sag of 0")
    states = tuple(
        State(theta_0=plan.run.theta_0, pull=tuple(pull), before=i - 1, kind=plan.run.kind, chain=0)
        for i, pull in enumerate(plan.pull.tolist())
    )
    return _collect(world, plan, list(predict_statics(world.design, states, world.winders).shapes))


def _visit(rig: SettleRig, world: World, plan: Plan) -> Iterator[Settled]:
    if plan.run.kind == "rest":
        return rig.visit()
    visited = rig.visit([Stage(pull=told - world.winders.slack) for told in plan.pull])
    next(visited)  # At rest, before anything is pulled.
    return visited


def _check(world: World, plan: Plan) -> None:
    if plan.pull.shape[1] != world.design.n_cable:
        cables = f"{plan.pull.shape[1]} cables, the world {world.design.n_cable}"
        raise ModelError(f"the plan has {cables}; allowed: a plan of the same trunk")


def _collect(world: World, plan: Plan, shapes: list[Shape]) -> Played:
    rotations = np.stack([shape.joint_rotation for shape in shapes])
    frames = base_orientation(plan.run.theta_0) @ section_frames(world.design, rotations)[..., :3, :3]
    return Played(
        plan=plan, ends=np.stack([shape.points for shape in shapes]), rotation=frames,
        unsettled=sum(int(shape.status) == Status.NOT_CONVERGED for shape in shapes),
    )  # fmt: skip
