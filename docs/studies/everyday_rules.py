"""What decides whether a trunk can take a thing, in numbers that follow from its design."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from spiraltrunk import strategies
from spiraltrunk.control.messages import Observation
from spiraltrunk.design.rules import GRAVITY
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import ModelError
from spiraltrunk.sim.objects.catalogue import parse_object
from spiraltrunk.sim.plant import SimPlant
from spiraltrunk.sim.robot.arm_ik import ArmReach
from spiraltrunk.sim.scene.options import SceneOptions
from spiraltrunk.strategies.assessment import assess
from spiraltrunk.strategies.fingertip.assess import SLAB, grip_force, held_width
from spiraltrunk.strategies.push.sweep import with_task
from spiraltrunk.strategies.wrap.assess import FLAT, TOUCH_FORCE, held_mass, wrapped_range
from spiraltrunk.strategies.wrap.standing_model import THIN_HEIGHT, least_width
from spiraltrunk.strategies.wrap.unsteady import TOUCH_HEIGHT
from spiraltrunk.workflows.grasp.choice.candidates import REACH_SLACK, follow_frames
from spiraltrunk.workflows.grasp.choice.ground import MARGIN

WRAPS = ("wrap-oblique-low", "wrap-oblique", "wrap-horizontal")
WIDTHS = (0.050, 0.080, 0.120)
"""Widths of standing cylinders whose least height is told [m]."""
FRICTION = 0.8
"""Announced friction between silicone and object [-]."""
GROUNDS = (0.60, 0.45, 0.30)
"""Heights of the ground [m]."""


def compute_rules(design: TrunkDesign) -> dict[str, str]:
    """Limits of a design in words and numbers, by what they limit."""
    gripper = design.gripper
    assert gripper is not None
    least, most = wrapped_range(design)
    observation = SimPlant(design, standing_scene()).reset()
    heights = [find_least_height(observation, width) for width in WIDTHS]
    top = find_reach(design)
    tallest = [find_tallest(observation, ground, top) for ground in GROUNDS]
    return {
        "width of a wrapped object": (
            f"{1e3 * least:.0f} to {1e3 * most:.0f} mm, from {1e3 * least_width(design):.0f} mm where it is "
            f"{1e3 * THIN_HEIGHT * design.length:.0f} mm tall"
        ),
        "section of a wrapped object": f"at most {FLAT:g} to 1",
        f"least height of a cylinder {_list(WIDTHS)} mm wide, wrapped": f"{_list(heights)} mm",
        "sideways push that a standing object must bear": (
            f"{TOUCH_FORCE:.3g} N at {100 * TOUCH_HEIGHT:.0f} % of its height"
        ),
        "mass that a wrap holds": ", ".join(
            f"{held_mass(design, width):.1f} kg at {1e3 * width:.0f} mm" for width in WIDTHS
        ),
        "width between the fingers": f"up to {1e3 * held_width(gripper):.0f} mm",
        "shorter side of what stands on unequal sides, between the fingers": (
            f"up to {1e3 * SLAB * gripper.grasp_width:.0f} mm"
        ),
        f"mass that the fingers hold at a friction of {FRICTION:g}": (
            f"{1e3 * FRICTION * grip_force(gripper) / GRAVITY:.0f} g"
        ),
        "height of the base that the arm reaches": f"{top:.2f} m",
        f"tallest object that the fingers lift over a ground at {_list(GROUNDS, 1.0)} m": f"{_list(tallest)} mm",
    }


def _list(values: tuple[float, ...] | list[float], scale: float = 1e3) -> str:
    return ", ".join(f"{scale * value:.3g}" if value > 0 else "none" for value in values)


def standing_scene() -> SceneOptions:
    """A cylinder that stands on the ground."""
    shape = parse_object("cylinder:diameter_mm=60,height_mm=120,mass_g=200")
    return SceneOptions(shape=shape, support="ground", orientation="upright", position=(0.46, 0.12, 0.0))


def find_least_height(observation: Observation, width: float) -> float:
    """Least height of a standing cylinder that one of the wraps can take and has a plan for, to 5 mm [m]."""
    for height in np.arange(0.030, 0.300, 0.005):
        observed = resize(observation, width, float(height))
        for name in WRAPS:
            try:
                strategies.get(name).init(observed)
            except ModelError:
                continue
            if assess(strategies.get(name), observed.task).feasible:
                return float(height)
    return 0.0


def resize(observation: Observation, width: float, height: float, ground: float | None = None) -> Observation:
    """The observation with a standing cylinder of another size, on the same or on another ground [m]."""
    task = observation.task
    before = task.goal.ground
    assert before is not None
    ground = before if ground is None else ground
    middle = np.array([*task.target.position[:2], ground + height / 2])
    target = replace(task.target, width=width, length=height, position=middle, profile=None)
    place = np.array([*task.goal.place[:2], ground + height / 2])
    return with_task(observation, replace(task, target=target, goal=replace(task.goal, ground=ground, place=place)))


def find_reach(design: TrunkDesign) -> float:
    """Largest height of the hanging trunk's base over the scene's object that the arm reaches, to 1 cm [m]."""
    arm = ArmReach(design)
    frame = arm.T_base(arm.home)
    for height in np.arange(1.20, 1.70, 0.01):
        frame[:3, 3] = *standing_scene().position[:2], height
        short, _ = follow_frames(arm, arm.home, [frame])
        if short > REACH_SLACK:
            return float(height) - 0.01
    return 1.70


def find_tallest(observation: Observation, ground: float, top: float) -> float:
    """Height of the tallest cylinder that `tip-grip` lifts and carries below a highest base ``top``, to 5 mm [m]."""
    tallest, fingers = 0.0, strategies.get("tip-grip")
    for height in np.arange(0.030, 0.400, 0.005):
        try:
            base = fingers.highest_base(resize(observation, 0.030, float(height), ground).task)
        except ModelError:
            break
        if base is None or base + MARGIN > top:
            break
        tallest = float(height)
    return tallest
