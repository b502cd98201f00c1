"""Supports of an object: strings and a table to set it down on, or the ground."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import mujoco
import numpy as np

from spiraltrunk.sim.objects.catalogue import ObjectSpec, add_object
from spiraltrunk.sim.robot.materials import SOLIMP, SOLREF

if TYPE_CHECKING:
    from spiraltrunk.sim.scene.options import SceneOptions

STRING = 1.0
"""Height of the strings' anchors above the object [m]."""

SLOT = 0.06
"""Half the width of the slot in the table, through which the trunk withdraws from the object [m] (ours)."""

TABLE_DEPTH = 0.30
"""Depth of the table in the direction of the transport [m] (ours)."""

GROOVE = math.radians(8.0)
"""Slope of the table towards its middle [rad] (ours); from a flat table a round object rolls off at release."""

ROLLING_FRICTION = 1e-3
"""Coefficient of rolling friction of the table's felt [m] (ours)."""

GROUND_NEAR, GROUND_FAR, GROUND_HALF_WIDTH = 0.20, 1.30, 1.00
"""Extent of the ground along x from the arm's base, and half its width [m] (ours)."""


def object_quat_wxyz(options: SceneOptions) -> np.ndarray:
    """Initial orientation of the object: axis horizontal or vertical, then rotated by the true yaw, shape (4,) [-]."""
    half = (options.yaw + options.yaw_error) / 2
    turn = np.array([math.cos(half), 0.0, 0.0, math.sin(half)])
    if options.orientation == "upright":
        up = np.array([math.sqrt(0.5), 0.0, -math.sqrt(0.5), 0.0])
        mujoco.mju_mulQuat(turn, turn.copy(), up)
    return turn


def add_hung_object(spec: mujoco.MjSpec, options: SceneOptions) -> None:
    """Add the object on two strings, tendons with an upper limit of the length, which only pull."""
    body = add_object(spec, options.shape)
    center = np.array(options.position) + np.array(options.offset)
    body.pos, body.quat = center, object_quat_wxyz(options)
    yaw, half = options.yaw + options.yaw_error, options.shape.size[0] / 2
    for side, x in (("left", -half), ("right", half)):
        end = np.array([x * math.cos(yaw), x * math.sin(yaw), STRING])
        anchor = spec.worldbody.add_site(name=f"anchor_{side}", pos=center + end, size=[0.004] * 3)
        string = spec.add_tendon(
            name=f"string_{side}", limited=True, range=[0.0, STRING], width=0.0015, rgba=[0.25, 0.25, 0.25, 1],
            solref_limit=[0.01, 1],
        )  # fmt: skip
        string.wrap_site(anchor.name)
        string.wrap_site(f"object_{side}")


def add_table(spec: mujoco.MjSpec, options: SceneOptions, place: np.ndarray) -> None:
    """Add a felt-covered table in two halves, with a slot between and a shallow groove, at ``place``, shape (3,) [m].

    The groove keeps a round object from rolling off. The trunk withdraws through the slot, which the object bridges.
    """
    half = options.shape.size[0] / 2
    slot = max(0.0, min(SLOT, half - 0.035))
    wide = (half + 0.02 - slot) / 2
    bottom = float(place[2]) - options.shape.size[2] / 2 / math.cos(GROOVE)
    board = np.array([wide, TABLE_DEPTH / 4 / math.cos(GROOVE), 0.008])
    for side, sign in (("near", -1.0), ("far", 1.0)):
        middle = place[0] + sign * (slot + wide)
        for part, slope in (("front", -1.0), ("back", 1.0)):
            normal = np.array([0.0, -slope * math.sin(GROOVE), math.cos(GROOVE)])
            surface = np.array(
                [middle, place[1] + slope * TABLE_DEPTH / 4, bottom + TABLE_DEPTH / 4 * math.tan(GROOVE)]
            )
            spec.worldbody.add_geom(
                name=f"table_{side}_{part}", type=mujoco.mjtGeom.mjGEOM_BOX, size=board, rgba=[0.62, 0.46, 0.30, 1],
                pos=surface - board[2] * normal, quat=[math.cos(GROOVE / 2), slope * math.sin(GROOVE / 2), 0, 0],
                solref=SOLREF, solimp=SOLIMP, condim=6, priority=2,
                friction=[options.shape.friction, 0.005, ROLLING_FRICTION],
            )  # fmt: skip
        foot = (bottom - 0.016) / 2
        spec.worldbody.add_geom(
            name=f"table_{side}_leg", type=mujoco.mjtGeom.mjGEOM_BOX, size=[wide, 0.02, foot],
            pos=[middle, place[1], foot], rgba=[0.45, 0.34, 0.24, 1],
        )  # fmt: skip


def add_ground(spec: mujoco.MjSpec, options: SceneOptions) -> None:
    """Add a platform before the arm, and the object on it."""
    spec.worldbody.add_geom(
        name="ground", type=mujoco.mjtGeom.mjGEOM_BOX, material="tiles",
        size=[(GROUND_FAR - GROUND_NEAR) / 2, GROUND_HALF_WIDTH, options.ground / 2],
        pos=[(GROUND_FAR + GROUND_NEAR) / 2, 0.0, options.ground / 2], solref=SOLREF, solimp=SOLIMP,
    )  # fmt: skip
    body = add_object(spec, options.shape)
    if options.shape.kind != "box":
        for geom in body.geoms:
            geom.condim = 6  # With rolling friction; without it, a cylinder never stops rolling.
    center = np.array(options.position) + np.array(options.offset)
    body.pos, body.quat = [*center[:2], rest_height(options, options.shape)], object_quat_wxyz(options)


def rest_height(options: SceneOptions, shape: ObjectSpec) -> float:
    """Height of an object's centre at rest on the ground [m]."""
    return options.ground + shape.size[0 if options.orientation == "upright" else 2] / 2
