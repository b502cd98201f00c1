"""Assessment of the wraps: width, weight, proportions and the push that topples a standing object."""

from __future__ import annotations

import math

from spiraltrunk.control.messages import Target, Task
from spiraltrunk.control.strategy import Assessment
from spiraltrunk.design.rules import graspable_range, payload
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import ModelError
from spiraltrunk.strategies.object_measures import (
    height_of,
    is_upright,
    narrowing,
    topple_angle_of,
    widths_between,
)
from spiraltrunk.strategies.scores import AT_LIMIT, accept, margin_factor, refuse, tell_apart
from spiraltrunk.strategies.wrap.approach import OBLONG
from spiraltrunk.strategies.wrap.distal_plan import find_rim
from spiraltrunk.strategies.wrap.standing import StandingWrap
from spiraltrunk.strategies.wrap.standing_model import girth_width, least_width, loop_band, wrapped_width
from spiraltrunk.strategies.wrap.unsteady import push_that_topples

RATES = {"wrap-vertical": 0.96, "wrap-oblique-low": 0.98, "wrap-oblique": 0.95, "wrap-horizontal": 0.97}
"""Rates of success with ample margins [-] (ours). That of `wrap-oblique-low` and the factors of standing things below
are fitted to the first tries with 658 drawn everyday things (docs/howto/choose.md); the two other standing wraps have
the ratios of earlier counts over the catalogue, and `wrap-vertical` its rate there."""
TOUCH_FORCE = 0.035
"""Horizontal force with which the trunk pushes a standing object as it closes, at least [N] (ours): in simulated trials
with drawn things none of 5 that topple at less was held, of 33 that topple at 0.035 to 0.055 N 25 were
(docs/validation/grasp_limits.md)."""
OPENING_FORCE, AT_OPENING = 0.055, 0.25
"""Force with which the opening trunk pushes a standing object, at least [N], and the factor of what topples at less
[-] (ours): of these 33, 8 were lifted and set down."""
AMPLE_TOPPLE, AT_TOPPLE = 0.06, 0.52
"""Force beyond that by which an object stands with an ample margin [N], and the factor without a margin [-]
(fitted)."""
AMPLE_HEIGHT, AT_HEIGHT = 0.23, 0.66
"""Height beyond `LOW` that is ample, over the trunk's length, and the factor without a margin [-] (fitted)."""
ROUND, SIDES_MOST, AT_SIDES = 1.1, 2.7, 0.63
"""Largest ratio of the widths seen from above with an ample margin, the ratio without a margin, and the factor
there [-] (fitted)."""
FLAT = 3.5
"""Largest ratio of the widths seen from above that a loop holds [-] (ours)."""
RIM = 0.75
"""Least distance of a distal wrap's middle below the object's top, over the radius of its first section [-] (ours):
nearer to it the round sections press on the rim and slip over it. In simulated trials none of 7 objects with less was
held (docs/validation/grasp_limits.md)."""
HELD_WIDTH = 0.57
"""Largest width that a wrap holds, over the largest that the trunk encloses [-]: in simulated trials 150 mm of 268 mm;
at 165 mm none was held (docs/validation/strategies.md)."""
HELD_LOAD = 0.38
"""Mass that a wrap holds, over the paper's empirical payload [-]: in simulated trials 1.5 kg of 4.0 kg at 60 mm, 1 kg
of 2.8 kg at 120 mm (docs/validation/strategies.md)."""
OBLONG_LOAD = 0.6
"""Mass that a wrap of an oblong object holds, over that of a round one of its girth [-] (ours): of drawn things at 0.5
to 0.6 of it 8 of 15 were lifted and set down when forced; of 160 others none of 5 oblong ones of 0.68 to 1.0 kg."""
OBLONG_SIDE = 0.485
"""Longest side of an oblong object that a wrap takes, over the largest width that the trunk encloses [-] (ours):
longer ones meet the housing. Of 4 drawn things 138 to 159 mm long, with 14 trials, 2 were held; of 3 up to 128 mm long
and lighter than 170 g, with 18 trials, 14."""
OBLONG_GIRTH = 0.382
"""Width of the cylinder of an oblong object's girth up to which a wrap takes it, over the largest that the trunk
encloses [-] (ours): of 7 trials with drawn things of 99.1 to 102.3 mm, taller than wide, 6 succeeded, of 8 with
things of 104 to 115 mm one."""
SQUAT, SQUAT_HEIGHT = 0.37, 1.15
"""Largest width seen from above that a wrap takes at any height, over the largest that the trunk encloses, and least
height of what is wider, over its width [-] (ours): of 24 drawn things that were wider and not as tall 8 were lifted
and set down (docs/validation/grasp_limits.md)."""
DISTAL_HEIGHT, DISTAL_LOAD = 0.26, 0.36
"""Height below which oblique wraps of wide things are distal, over the trunk's length, and mass that is then held, over
that of a full wrap [-] (ours): the thinner sections give way. Of drawn things at 0.30 to 0.36 of it 5 of 8 were lifted
and set down when forced."""
LOW = 0.137
"""Least height of a standing object, over the trunk's length [-] (ours): of 17 trials with drawn things of 69 to 74 mm
11 succeeded, of 11 with lower ones none; most of these toppled as the tail went round them."""
AMPLE_WIDTH, AT_WIDTH = 0.15, 0.3
"""Distance from the ends of the graspable range with an ample margin, over the width (ours: trials draw 10 %), and the
factor of a standing thing without a margin (fitted) [-]."""
AMPLE_LOAD, AT_LOAD = 0.5, 0.2
"""Part of that mass that is left with an ample margin (ours), and the factor of a standing thing without a margin
(fitted) [-]."""
NARROWING, NARROWING_HEIGHT = math.radians(13.0), 0.27
"""Largest angle by which the sides of a standing object narrow upwards all along its loop [rad], of objects that are
higher than this part of the trunk's length [-] (ours): the loop slips over steeper sides. Of drawn tall objects of 10
to 13 deg 8 of 10 were lifted and set down, none of 2 steeper ones; of lower ones of 10 to 34 deg 11 of 13."""
AMPLE_NARROWING, AT_NARROWING = math.radians(6.0), 0.7
"""Part of that angle that is left with an ample margin [rad], and the factor at the angle [-] (ours): frusta 90 mm wide
and 160 mm tall succeeded in 15 of 15 simulated trials at 2 to 6 deg, 4 of 5 at 8 deg and 3 of 5 at 10 deg."""
POINTED, POINT_HEIGHT = 0.1, 0.95
"""Width of a pointed object over its largest, and the part of its height at which it is taken [-] (ours): of 42 trials
with cones of 7 to 27 deg 7 succeeded."""
SHORT = 1.5
"""Least length of a hung object over its width [-] (ours): a shorter one slips out of the loop sideways."""


def assess_hung(task: Task) -> Assessment:
    """Whether the trunk can wrap an object on strings: width, payload and length along its axis."""
    design, target = task.design, task.target
    if task.goal.ground is not None:
        return refuse("the object rests on the ground; this wrap takes one that hangs")
    widths = wrapped_range(design)
    unfit = _find_misfit(task, target.width, widths)
    if unfit is not None:
        return refuse(unfit)
    ratio = target.length / target.width
    if ratio < SHORT:
        told = math.floor(100 * ratio) / 100  # Rounded, a ratio just below the limit would read as the limit.
        return refuse(f"too short to stay in the loop: {told:g} times as long as wide, {SHORT:g} needed")
    heaviest = held_mass(design, target.width)
    factors = _margins(task, target.width, heaviest, AT_LIMIT, AT_LIMIT)
    return accept(RATES["wrap-vertical"], factors, _describe(task, target.width, widths, heaviest))


def assess_standing(strategy: StandingWrap, task: Task) -> Assessment:
    """Whether the trunk can wrap an object on the ground: width, payload, proportions, and the push that topples it.

    Whether it is tall enough for the housing to clear the ground is for the plan of the moves.
    """
    design, target = task.design, task.target
    if task.goal.ground is None:
        return refuse("the object hangs; this wrap takes one that stands on the ground")
    if target.kind != "sphere" and not is_upright(target):
        return refuse("the object lies; this wrap takes one that stands")
    around = wrapped_width(target)
    heaviest = held_mass(design, around) * (OBLONG_LOAD if _is_oblong(target) else 1.0)
    widths = least_width(design, height_of(target)), wrapped_range(design)[1]
    unfit = _find_misfit(task, around, widths) or _find_outline_misfit(task, around, heaviest)
    if unfit is not None:
        return refuse(unfit)
    force = push_that_topples(target)
    if force < TOUCH_FORCE:
        return refuse(f"would topple at {force:.2g} N; the closing trunk pushes with {TOUCH_FORCE:g} N or more")
    slip = _find_slope(task) or _find_rim(strategy, task)
    if slip is not None:
        return refuse(slip)
    tall, lowest = height_of(target), LOW * design.length
    if tall < lowest:
        return refuse(f"too short by {_compare(tall, lowest)} of height or more")
    factors = _margins(task, around, heaviest, AT_WIDTH, AT_LOAD) | {
        "topple": _topple_factor(force),
        "height": margin_factor(tall - lowest, AMPLE_HEIGHT * design.length, AT_HEIGHT),
        "unequal sides": _sides_factor(target),
        "narrowing": _narrowing_factor(task),
    }
    stands = f"topples at {force:.2g} N"
    return accept(
        RATES.get(strategy.name, min(RATES.values())),
        factors,
        f"{_describe(task, around, widths, heaviest)}; {stands}",
    )


def _find_slope(task: Task) -> str | None:
    """Why the loop slips over an object that narrows upwards; None where it holds."""
    target, angle = task.target, narrowing(task.target, *loop_band(task.target))
    if angle == 0.0:
        return None
    tall, widest = height_of(target), wrapped_width(target)
    if girth_width(target, POINT_HEIGHT * tall) < POINTED * widest or target.kind == "cone":
        return "would slip out of the loop: it narrows upwards to a point"
    if angle <= NARROWING or tall <= NARROWING_HEIGHT * task.design.length:
        return None
    told, limit = math.degrees(angle), math.degrees(NARROWING)
    return f"would slip out of the loop: its sides narrow upwards by {told:.3g} deg, at most {limit:.0f} deg hold"


def _narrowing_factor(task: Task) -> float:
    """Factor of the angle by which the sides of a tall object narrow upwards [-]."""
    if height_of(task.target) <= NARROWING_HEIGHT * task.design.length:
        return 1.0
    return margin_factor(NARROWING - narrowing(task.target, *loop_band(task.target)), AMPLE_NARROWING, AT_NARROWING)


def _find_rim(strategy: StandingWrap, task: Task) -> str | None:
    """Why the sections that close round a short object slip over its rim; None where they do not.

    An object that is too short for any plan is for the plan to refuse.
    """
    try:
        below, radius = find_rim(task, strategy.plane)
    except ModelError:
        return None
    if below >= RIM * radius:
        return None
    return (
        f"too short: the trunk would press {1e3 * below:.0f} mm below its top and slip over it; its sections of "
        f"{1e3 * radius:.0f} mm radius need {math.ceil(1e3 * RIM * radius)} mm"
    )


def wrapped_range(design: TrunkDesign) -> tuple[float, float]:
    """Least and largest width that a wrap holds [m]; the largest is 0 where it holds nothing."""
    least, most = graspable_range(design)
    return least, HELD_WIDTH * most if HELD_WIDTH * most >= least else 0.0


def held_mass(design: TrunkDesign, width: float) -> float:
    """Largest mass of ``width`` [m] that a wrap holds [kg]."""
    return HELD_LOAD * payload(design, width)


def _compare(width: float, limit: float) -> str:
    """By how much a width or height passes a limit [m], and both."""
    by, width_text, limit_text = tell_apart(width, limit)
    return f"{by} mm: {width_text} mm, it wraps {limit_text} mm"


def _find_misfit(task: Task, width: float, widths: tuple[float, float]) -> str | None:
    """What of width or mass is out of the trunk's range; None where nothing is."""
    least, most = widths
    if most == 0.0:
        return "the trunk is too short to wrap anything"
    if width > most:
        return f"too wide for the trunk by {_compare(width, most)}"
    if width < least:
        return f"too thin for the trunk by {_compare(width, least)} or more"
    heaviest = held_mass(task.design, width)
    return _too_heavy(task.target.mass, heaviest, "at that width") if task.target.mass > heaviest else None


def _find_outline_misfit(task: Task, around: float, heaviest: float) -> str | None:
    """Why no loop goes round a standing object, or it would not stay in one; None where nothing is in the way.

    Args:
        task: trunk and object as announced.
        around: width of the cylinder of the object's girth [m].
        heaviest: largest mass of the object that a wrap holds [kg].
    """
    target, enclosed = task.target, graspable_range(task.design)[1]
    least, most = widths_between(target, *loop_band(target))
    if most > FLAT * least:
        return f"too flat for a loop: {1e3 * most:.0f} x {1e3 * least:.0f} mm, at most {FLAT:g} to 1"
    widest, longest = HELD_WIDTH * enclosed, OBLONG_SIDE * enclosed
    if most > widest:
        across = f"{1e3 * most:.0f} mm across, with handle and corners; it goes round {1e3 * widest:.0f} mm"
        return _too_long(most - widest, across)
    if _is_oblong(target) and target.longer_side > longest:
        along = f"its longer side is {1e3 * target.longer_side:.0f} mm; it takes {1e3 * longest:.0f} mm"
        return _too_long(target.longer_side - longest, along)
    if _is_oblong(target) and around > OBLONG_GIRTH * enclosed:
        return f"too wide for an object with unequal sides by {_compare(around, OBLONG_GIRTH * enclosed)}"
    if target.mass > heaviest:  # A round one has been refused by its width.
        return _too_heavy(target.mass, heaviest, "for an object with unequal sides")
    low, borne = DISTAL_HEIGHT * task.design.length, DISTAL_LOAD * held_mass(task.design, around)
    if height_of(target) < low and target.mass > borne:
        return _too_heavy(target.mass, borne, f"where an object is lower than {1e3 * low:.0f} mm")
    if topple_angle_of(target) == 0.0:
        return "would roll away: nothing keeps it in place as the trunk touches it"
    if most > SQUAT * enclosed and height_of(target) < SQUAT_HEIGHT * most:
        tall, needed = 1e3 * height_of(target), math.ceil(1e3 * SQUAT_HEIGHT * most)
        return f"too short for its width: {tall:.0f} mm tall; what is {1e3 * most:.0f} mm across needs {needed} mm"
    return None


def _too_long(excess: float, limit: str) -> str:
    return f"too long for the trunk's loop by {max(1.0, 1e3 * excess):.0f} mm: {limit}"


def _too_heavy(mass: float, heaviest: float, where: str) -> str:
    by = max(1, round(1e3 * (mass - heaviest)))
    return f"too heavy by {by} g: the trunk holds {1e3 * heaviest:.0f} g {where}"


def _is_oblong(target: Target) -> bool:
    """Whether one side of a standing object is by `OBLONG` longer than the other."""
    return target.longer_side > OBLONG * widths_between(target, *loop_band(target))[0]


def _margins(task: Task, width: float, heaviest: float, at_width: float, at_load: float) -> dict[str, float]:
    least, most = wrapped_range(task.design)
    return {
        "width": margin_factor(min(most - width, width - least) / width, AMPLE_WIDTH, at_width),
        "load": margin_factor(1 - task.target.mass / heaviest, AMPLE_LOAD, at_load),
    }


def _topple_factor(force: float) -> float:
    """Factor of the ``force`` that topples a standing object [N] [-]; far less of what the opening trunk topples."""
    return AT_OPENING if force < OPENING_FORCE else margin_factor(force - OPENING_FORCE, AMPLE_TOPPLE, AT_TOPPLE)


def _sides_factor(target: Target) -> float:
    """Factor of the widths' ratio seen from above [-]; what has a handle counts with it."""
    least, most = widths_between(target, *loop_band(target))
    return margin_factor(SIDES_MOST - most / least, SIDES_MOST - ROUND, AT_SIDES)


def _describe(task: Task, width: float, widths: tuple[float, float], heaviest: float) -> str:
    least, most = (1e3 * limit for limit in widths)
    fits = f"{1e3 * width:.0f} mm wide, the trunk wraps {least:.0f} to {most:.0f} mm"
    return f"{fits}; {1e3 * task.target.mass:.0f} g, it holds {1e3 * heaviest:.0f} g"
