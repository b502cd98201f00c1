"""Assessment of the strategies that grip with the fingers at the tip: opening, friction, and the flip."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from spiraltrunk.control.messages import Target, Task
from spiraltrunk.control.strategy import Assessment
from spiraltrunk.design.gripper import GripperDesign
from spiraltrunk.design.rules import GRAVITY
from spiraltrunk.errors import ModelError
from spiraltrunk.strategies.fingertip.cycle import TipStrategy
from spiraltrunk.strategies.fingertip.finger_model import closing_tension
from spiraltrunk.strategies.fingertip.flip_grip import TURN, FlipGrip, find_flip
from spiraltrunk.strategies.fingertip.gripped_object import as_gripped, is_slab
from spiraltrunk.strategies.fingertip.plan import tip_height
from spiraltrunk.strategies.fingertip.tip_grip import Pinch
from spiraltrunk.strategies.object_measures import cone_slope, height_of, is_upright, topple_force, widths_between
from spiraltrunk.strategies.scores import accept, margin_factor, refuse, tell_apart

RATE = 0.94
"""Rate of success with ample margins [-] (ours), of `pinch` and `flip-grip` too: tip grips of the paper's fingers took
87 of 96 drawn everyday things at once (docs/howto/choose.md), where 0.98, that over their catalogue, foretold 91."""
FLIP = 0.95
"""Factor of the flip, a motion more than the tip grip's [-] (ours)."""
OTHER_SHAPE = 0.97
"""Factor of a pinch of a compact object, and of a tip grip of an elongated one [-] (ours): the grips are the same, and
their names tell the objects that they are meant for."""
ELONGATED = 1.5
"""Ratio of the widths seen from above from which an object counts as elongated [-]."""
BAND = 0.35
"""Part of a finger's length that touches the object [-] (ours): about the last phalanx."""
HELD_OPENING = 0.97
"""Part of the opening up to which an object counts as held (ours) [-]. Where friction does not creep, fingers that open
40 mm lifted and set down balls and standing cylinders of 36, 38 and 40 mm in 45 of 45 simulated trials, and those that
open 70 mm such of 64 and 67 mm in 20 of 20, of 70 mm in 7 of 10; drawn things of 35 to 39 mm in 38 of 46."""
SLAB, FLIP_SLAB = 0.9, 0.8
"""Largest shorter side of what stands on unequal sides, over the fingers' opening, and that of what is flipped [-]
(ours): wider ones the fingertips touch at the upper edge. Forced, fingers that open 40 mm lifted and set down 28 of 54
drawn things of 32 to 36 mm, and 10 of 22 of 29 to 32 mm that they flipped."""
AMPLE_SLAB, AT_SLAB = 0.15, 0.45
"""Part of the opening that is left up to that with an ample margin, and the factor at that limit [-] (ours)."""
UNSTEADY, STEADY, AT_UNSTEADY = 0.018, 0.054, 0.35
"""Pushes at its top by which such an object topples: up to the first one it is least surely set down, from the second
most [N]; and the factor at the first [-] (ours). One finger presses against two, and moves the top as they open. Of
objects up to 29 mm that topple at less than 0.042 N fingers that open 40 mm held 40 of 44 and set down 16, of steadier
ones they set down 32 of 32."""
AMPLE_OPENING, AT_OPENING = 0.05, 0.88
"""Part of the opening that is left up to HELD_OPENING with an ample margin, and the factor there [-] (ours): of drawn
things beside that limit 38 of 46 succeeded."""
ROUND_TOP, ROUND = 0.9, 0.7
"""Share of a lying object's height at which its least width tells a round side, and the largest there over the whole
[-] (ours): 0.6 of a cylinder's, all of a box's."""
LONGEST = 0.7
"""Greatest length of a lying object [m] (ours): an error of the seen axis lifts an end of a longer one above what the
fingers clear. Pinches of bars 12 and 20 mm thick succeeded in 5 of 6 trials at 700 mm, 3 of 6 at 800 and 1 of 4 at
999 mm."""
AMPLE_GRIP = 0.6
"""Part of the friction that is left with an ample margin [-]: trials draw down to 0.5 of an announced 0.8."""


def assess_fingers(strategy: TipStrategy, task: Task) -> Assessment:
    """Whether the fingers open round the object and hold its weight by friction."""
    stands_across, push, task = is_slab(task), topple_force(task.target, height_of(task.target)), as_gripped(task)
    gripper, target = task.design.gripper, task.target
    if gripper is None:
        return refuse("the trunk has no gripper")
    if task.goal.ground is None:
        return refuse("the object hangs; the fingers take what rests on the ground")
    if not is_upright(target) and target.length > LONGEST:
        by, own, limit = tell_apart(target.length, LONGEST)
        return refuse(f"too long by {by} mm: {own} mm, the fingers lift lying objects of up to {limit} mm")
    least, most = _gripped_widths(gripper, target)
    weight, hold = target.mass * GRAVITY, _holding_force(gripper, target)
    slab = FLIP_SLAB if isinstance(strategy, FlipGrip) else SLAB
    widest = slab * gripper.grasp_width if stands_across else held_width(gripper)
    refusal = _refuse_width(gripper, least, widest, stands_across) or _refuse_weight(target, weight, hold)
    if refusal is not None:
        return refusal
    try:
        tip_height(replace(task, target=replace(target, kind="cylinder")) if is_round(target) else task)
        if isinstance(strategy, FlipGrip):
            find_flip(task.design, target.mass, TURN)
    except ModelError as error:
        return refuse(str(error))
    open_ = gripper.grasp_width
    ample, at_limit = (AMPLE_SLAB, AT_SLAB) if stands_across else (AMPLE_OPENING, AT_OPENING)
    factors = {
        "opening": margin_factor((widest - least) / open_, ample, at_limit),
        "friction": margin_factor(1 - weight / hold, AMPLE_GRIP),
        "shape": 1.0 if isinstance(strategy, Pinch) == (most > ELONGATED * least) else OTHER_SHAPE,
        "flip": FLIP if isinstance(strategy, FlipGrip) else 1.0,
        "topple": margin_factor(push - UNSTEADY, STEADY - UNSTEADY, AT_UNSTEADY) if stands_across else 1.0,
    }
    across = f"the fingers open {1e3 * open_:.0f} mm round {1e3 * least:.0f} mm"
    return accept(RATE, factors, f"{across} and hold {hold:.2g} N by friction, it weighs {weight:.2g} N")


def _refuse_width(gripper: GripperDesign, width: float, widest: float, stands_across: bool) -> Assessment | None:
    """Refusal of an object whose gripped width [m] the fingers do not open round, or do not hold; None for others.

    They hold up to ``widest`` [m]. ``stands_across`` says that the object stands, and the width is that of its shorter
    side.
    """
    open_ = gripper.grasp_width
    if stands_across and width > widest:
        by, own, limit = tell_apart(width, widest)
        side = f"its shorter side is {own} mm, they hold {limit} mm of what stands so"
        return refuse(f"too wide for the fingers by {by} mm: {side}")
    if width > open_:
        by, own, limit = tell_apart(width, open_)
        return refuse(f"too wide for the fingers by {by} mm: {own} mm, they open {limit} mm")
    if width > widest:
        by, own, limit = tell_apart(width, widest)
        held = f"they open {1e3 * open_:.0f} mm and hold what is up to {limit} mm wide"
        return refuse(f"too wide for the fingers by {by} mm: {own} mm, {held}")
    return None


def _refuse_weight(target: Target, weight: float, hold: float) -> Assessment | None:
    """Refusal of an object that weighs more than friction holds, both [N]; None for others."""
    if weight <= hold:
        return None
    slope = cone_slope(target)
    if slope > 0:
        cone, steepest = math.degrees(slope), math.degrees(math.atan(target.friction))
        able = f"the fingers hold {hold:.2g} N" if hold > 0 else "no grip holds it"
        return refuse(
            f"would slip off its slope: it narrows upwards by {cone:.0f} deg, friction holds up to {steepest:.0f} deg; "
            f"it weighs {weight:.2g} N, {able}"
        )
    return refuse(f"would slip: it weighs {weight:.2g} N, the fingers hold {hold:.2g} N by friction")


def _holding_force(gripper: GripperDesign, target: Target) -> float:
    """Largest weight that the fingers hold by friction, N (mu cos a - sin a) on a wall that narrows by a [N]."""
    slope = cone_slope(target)
    return (target.friction * math.cos(slope) - math.sin(slope)) * grip_force(gripper)


def held_width(gripper: GripperDesign) -> float:
    """Largest width of an object that the fingers hold [m]."""
    return HELD_OPENING * gripper.grasp_width


def is_round(target: Target) -> bool:
    """Whether a solid of another kind lies on a round side, as a barrel does: fingers pass its top as a cylinder's."""
    profile = target.profile
    if profile is None or is_upright(target) or target.kind in ("sphere", "box"):
        return False
    top = float(np.interp(ROUND_TOP * profile.height[-1], profile.height, profile.width_least))
    return top <= ROUND * float(profile.width_least.max())


def gripped_width(task: Task) -> float:
    """Width across which the fingers grip the object, where they touch it [m]; without a gripper, its announced one."""
    gripper, task = task.design.gripper, as_gripped(task)
    return task.target.width if gripper is None else _gripped_widths(gripper, task.target)[0]


def _gripped_widths(gripper: GripperDesign, target: Target) -> tuple[float, float]:
    return widths_between(target, *grip_band(gripper, height_of(target)))


def grip_force(gripper: GripperDesign) -> float:
    """Sum of the normal forces of all fingertips at the largest tension, the fingers straight [N]."""
    return gripper.n_finger * gripper.tension_max / closing_tension(gripper, gripper.mount_radius, 1.0)


def grip_band(gripper: GripperDesign, height: float) -> tuple[float, float]:
    """Lowest and highest point above the ground that the closed fingers touch on an object of ``height`` [m]."""
    low = max(0.0, height - (1.0 - BAND) * gripper.finger_length)
    return low, min(height, low + BAND * gripper.finger_length)
