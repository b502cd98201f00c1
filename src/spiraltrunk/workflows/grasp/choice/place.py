"""Place of an object: the usual one, or one further away where arm or trunk would have no room.

A hung object hangs beside the trunk as that hangs at the start, further aside and ahead by what the trunk is thicker
there than the paper's. A standing one is moved where the arm would come near its limits.

The base of a trunk that wraps a standing object stands behind it, by more the longer the trunk is, and nearer to the
arm's foot the further the approach is turned (`strategies.wrap.approach`).
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from spiraltrunk import strategies
from spiraltrunk.control.messages import Observation, Task
from spiraltrunk.control.strategy import Strategy
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import ModelError
from spiraltrunk.sim.robot.arm_ik import ArmReach
from spiraltrunk.sim.scene.build import PEDESTAL_CENTER, PEDESTAL_SIZE, build_task
from spiraltrunk.sim.scene.options import SceneOptions
from spiraltrunk.strategies.assessment import assess
from spiraltrunk.strategies.wrap.approach import is_turned
from spiraltrunk.strategies.wrap.standing import StandingWrap
from spiraltrunk.strategies.wrap.standing_plan import WRIST
from spiraltrunk.workflows.grasp.choice.candidates import list_strategies

AHEAD = (0.0, 0.05, 0.10, 0.15, 0.20)
"""Displacements of the object along the world's y, ahead of a standing wrap's base, in the order in which they are
tried [m] (ours)."""

BESIDE = tuple((x, y) for x in (0.06, 0.12, 0.18, 0.24) for y in (0.0, 0.10))
"""Further displacements along the world's x, away from the arm, and y, which turned approaches need [m] (ours)."""

MARGIN = np.radians(13.0)
"""Distance of every joint from the ends of its range, on the way of an object that stands where it is announced [rad]
(ours): the object's true place, 30 mm off, and the search for the touch take up to 12 deg of it."""

GEARING = 3.3
"""Largest share of its speed that a joint may use for 1 m/s of the base, on the same way [s/m] (ours): at 4.1, a curl
passed the arm's limit of acceleration. The paper's trunk needs 3.2."""

PEDESTAL_ROOM = 0.15
"""Level gap between the arm's wrist, taken as a point, and its pedestal at the ends of all moves [m] (ours): twice the
wrist's radius, as the object stands up to 30 mm off; without turns it is 167 mm at least."""

HUNG_ROOM, HUNG_TOP, HUNG_WIDTH = 0.073, 0.10, 0.120
"""Least level distance of the middle of a hung object, up to `HUNG_WIDTH` wide, from the surface of the trunk that
hangs at the start, and the height above the middle at which the trunk's radius counts [m] (ours): the paper's trunk
leaves 73.4 mm. An object of `HUNG_WIDTH` that hangs 30 mm off its announced place, both across and ahead, begins up to
1 mm in the trunk."""

_PERIOD, _STEPS = 0.1, 60
"""Period [s] and largest number of steps of the inverse kinematics on the way from one frame to the next."""


def choose_place(design: TrunkDesign, options: SceneOptions, strategy: Strategy[Any], arm: ArmReach) -> SceneOptions:
    """The scene with the object at the first place that suits the arm, else at the best one.

    There the arm keeps `MARGIN`, `GEARING` and `PEDESTAL_ROOM`.
    A scene for a strategy that tells no path of the base, or of an arm whose joints have no range, stays as it is.

    Raises:
        ModelError: where the strategy cannot plan for the object.
    """
    best, most = options, -np.inf
    x, y, z = options.position
    for aside, ahead in (*((0.0, ahead) for ahead in AHEAD), *BESIDE):
        tried = options if aside == ahead == 0.0 else replace(options, position=(x + aside, y + ahead, z))
        ease = _find_ease(design, tried, strategy, arm, least=most)
        if ease is None or ease >= 1.0:
            return tried
        if ease > most:
            best, most = tried, ease
    return best


def place_hung(design: TrunkDesign, options: SceneOptions, arm: ArmReach) -> SceneOptions:
    """The scene with a hung object, in its usual place, at least `HUNG_ROOM` beside the trunk as it hangs at the start.

    What is wider than `HUNG_WIDTH` has as much more room as its half is wider. An object that is moved for that is
    moved as far ahead, where its near end is beside the trunk.
    """
    if options.position != SceneOptions().position:
        return options
    x, y, z = options.position
    start = arm.T_base(arm.home)[:3, 3]
    section = np.searchsorted(np.cumsum(design.section_length), float(start[2]) - z - HUNG_TOP)
    if section >= design.n_section:
        return options
    wider = max(0.0, (options.announced or options.shape).width - HUNG_WIDTH) / 2
    least = float(start[1]) + HUNG_ROOM + wider + design.solid.radius * float(design.scale[section])
    return options if y >= least else replace(options, position=(x + least - y, least, z))


def place_for_wrap(design: TrunkDesign, options: SceneOptions, choice: Strategy[Any]) -> SceneOptions:
    """The scene with the object where a turned approach suits the arm, if a choice would give the object to a wrap.

    Args:
        design: the trunk.
        options: a scene with the usual ground.
        choice: the strategy that chooses among others.
    """
    task = choice.grasp_task(build_task(design, options))
    if not is_turned(task):
        return options
    names = list_strategies(options.support)
    found = {name: assess(strategies.get(name), task) for name in names}
    best = strategies.get(max(names, key=lambda name: found[name].score))
    if not isinstance(best, StandingWrap) or not found[best.name].feasible:
        return options
    try:
        return choose_place(design, options, best, ArmReach(design))
    except ModelError:  # The ranking tells why.
        return options


def _find_ease(
    design: TrunkDesign, options: SceneOptions, strategy: Strategy[Any], arm: ArmReach, least: float = -np.inf
) -> float | None:
    """Ease of the planned path for the arm, from 1 on where it suits the arm [-]; None where no path is known.

    Least distance of a joint from the ends of its range over `MARGIN`, `GEARING` over the largest one, or the gap to
    the pedestal over `PEDESTAL_ROOM`, whichever is less. A path whose ease falls to ``least`` is not followed further.
    """
    path = strategy.base_path(_observe_start(strategy.grasp_task(build_task(design, options)), arm))
    if path is None or arm.limits.position is None:
        return None
    low, high = arm.limits.position
    q, ease = arm.home, np.inf
    for frame in path:
        ease = min(ease, _find_pedestal_gap(frame) / PEDESTAL_ROOM)
        for reached in arm.steps(q, frame, _PERIOD, _STEPS):
            before, q = q, reached
            margin = float(np.minimum(q - low, high - q).min())
            ease = min(ease, margin / MARGIN, GEARING / max(arm.find_gearing(q), 1e-9))
            if np.abs(q - before).max() < 1e-3:
                break
        if ease <= least:
            return ease
    return ease


def _find_pedestal_gap(frame: np.ndarray) -> float:
    """Level distance from the pedestal of the arm's wrist behind a frame of the base, shape (4, 4) [m]."""
    wrist = frame[:2, 3] - WRIST[1] * frame[:2, 0]
    outside = np.maximum(np.abs(wrist - PEDESTAL_CENTER) - PEDESTAL_SIZE, 0.0)
    return float(np.linalg.norm(outside))


def _observe_start(task: Task, arm: ArmReach) -> Observation:
    """What a robot at its start observes without a camera: the object is where it is announced."""
    none = np.zeros(task.design.n_cable)
    return Observation(
        time=0.0, task=task, T_world_base=arm.T_base(arm.home), arm_position=arm.home,
        arm_velocity=0.0 * arm.home, cable_pull=none, cable_tension=none, base_force=np.zeros(3),
        base_torque=np.zeros(3),
    )  # fmt: skip
