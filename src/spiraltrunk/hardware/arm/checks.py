"""Checks before anything is sent to an arm: limits, targets, collision thresholds, load. Nothing is clamped."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeVar, final

import numpy as np

from spiraltrunk.checks import read_array, read_numbers
from spiraltrunk.control.arm_limits import QUANTITIES, ArmLimits, standstill_margin, velocity_bounds
from spiraltrunk.errors import DriveError, describe
from spiraltrunk.field_docs import explain_fields
from spiraltrunk.hardware.arm.arm_port import ArmLoad

_T = TypeVar("_T")

COLLISION_TORQUE = (20.0, 20.0, 18.0, 18.0, 16.0, 14.0, 12.0)
"""External joint torque at which a Franka arm stops by reflex [N m] (libfranka, examples_common.cpp)."""

COLLISION_FORCE = (20.0, 20.0, 20.0, 25.0, 25.0, 25.0)
"""External force [N] and torque [N m] at the end effector at which it stops by reflex (the same file)."""

EARLY = 0.25
"""Part of a period by which a target may come early at full speed [-] (ours)."""

STILL = 0.01
"""Joint speed below which the arm stands [rad/s] (ours: above the noise of measured speeds)."""

FARTHEST_LOAD = 2.0
"""Largest distance of a load's centre of mass from the flange [m] (ours: four trunks)."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class ArmSettings:
    """What an arm is checked against."""

    limits: ArmLimits
    """Limits of the arm; positions and speeds are required."""
    payload: float | None
    """Rated payload at the flange [kg]; None where none is published, then every load passes."""
    period: float = 0.02
    """Time between two targets, from 0.01 to 0.05 [s] (ours: 50 Hz)."""
    position_margin: float = 0.01
    """Distance from the ends of a joint's range that targets keep [rad] (ours)."""
    lead_time: float = 0.15
    """Largest lead of a target over the measured position, as time at the joint's speed limit [s] (ours)."""
    feedback_age: float = 0.05
    """Age of the measurement from which it counts as stale [s] (ours)."""

    def __post_init__(self) -> None:
        for name, least, most in (
            ("period", 0.01, 0.05), ("position_margin", 0.0, 1.0), ("lead_time", 0.02, 1.0),
            ("feedback_age", 0.01, 1.0),
        ):  # fmt: skip
            value = getattr(self, name)
            if not (isinstance(value, (float, int)) and least <= value <= most):
                raise DriveError(f"arm {name} is {describe(value)}; allowed: {least:g} to {most:g}")
        if self.payload is not None and not 0.0 < self.payload < 1000.0:
            raise DriveError(f"arm payload is {describe(self.payload)} kg; allowed: above 0, or None")
        _check_limits(self.limits)

    @property
    def n_joint(self) -> int:
        """Number of joints."""
        return int(np.asarray(self.limits.velocity).size)


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class CollisionThresholds:
    """External torques and forces at which the arm's controller stops it by reflex; they can only be lowered.

    Raises:
        DriveError: for a threshold that is not positive, or above the one that libfranka's examples set.
    """

    torque: tuple[float, ...] = COLLISION_TORQUE
    """Joint torques, seven numbers [N m]."""
    force: tuple[float, ...] = COLLISION_FORCE
    """Force [N] and torque [N m] at the end effector, six numbers."""

    def __post_init__(self) -> None:
        for name, most in (("torque", COLLISION_TORQUE), ("force", COLLISION_FORCE)):
            value = read_numbers(f"collision {name}", getattr(self, name), shape=(len(most),), error=DriveError)
            for i, (one, bound) in enumerate(zip(value.tolist(), most, strict=True)):
                if not 0.0 < one <= bound:
                    raise DriveError(
                        f"collision {name}[{i}] is {one:g}; allowed: above 0, at most {bound:g} "
                        "(larger ones disable the reflex that protects people)"
                    )


def intersect_limits(first: ArmLimits, second: ArmLimits) -> ArmLimits:
    """The tighter of two limits for each quantity; where one of them is unknown, the other.

    Raises:
        DriveError: where they are of arms with different numbers of joints.
    """
    sizes = sorted(_count_joints(first) | _count_joints(second))
    if len(sizes) > 1:
        given = " and ".join(map(str, sizes))
        raise DriveError(f"limits of the arm are for {given} joints; allowed: limits of the arm that is connected")
    position = _pick(first.position, second.position)
    if first.position is not None and second.position is not None:
        (low, high), (other_low, other_high) = first.position, second.position
        position = np.maximum(low, other_low), np.minimum(high, other_high)
    braking = _pick(first.braking, second.braking)
    if first.braking is not None and second.braking is not None:
        (offset, slow), (other_offset, other_slow) = first.braking, second.braking
        braking = np.maximum(offset, other_offset), np.minimum(slow, other_slow)
    return ArmLimits(
        position=position,
        velocity=_least(first.velocity, second.velocity),
        acceleration=_least(first.acceleration, second.acceleration),
        jerk=_least(first.jerk, second.jerk),
        torque=_least(first.torque, second.torque),
        braking=braking,
    )


def position_range(settings: ArmSettings) -> tuple[np.ndarray, np.ndarray]:
    """Least and largest target of each joint, two of shape (n_arm,) [rad].

    They keep the margin, and the distance within which a joint with published braking may not move towards its end.
    """
    low, high = settings.limits.position  # type: ignore[misc]
    margin = np.maximum(settings.position_margin, standstill_margin(settings.limits))
    return low + margin, high - margin


def read_target(settings: ArmSettings, position: np.ndarray) -> np.ndarray:
    """A target as floats, finite, one per joint and within `position_range`, shape (n_arm,) [rad].

    Raises:
        DriveError: with the joint, the value and what is allowed.
    """
    target = read_numbers("arm target", position, shape=(settings.n_joint,), unit="rad", error=DriveError)
    low, high = position_range(settings)
    i = _find_unfit((low <= target) & (target <= high))
    if i is not None:
        raise DriveError(f"arm target of joint {i + 1} is {target[i]:g} rad; allowed: {low[i]:g} to {high[i]:g} rad")
    return target.copy()


def compute_travel_time(settings: ArmSettings, previous: np.ndarray, target: np.ndarray) -> float:
    """Least time in which the arm gets from one target to the next [s], infinite where it never does.

    max_i |q_i - p_i| / v_i(q), with the speed limit at the target in the direction of the step, see `velocity_bounds`:
    along a step the limit falls.

    Raises:
        DriveError: where a number of joints is not finite, as of a broken measurement.
    """
    step = target - previous
    if not np.isfinite(step).all():
        raise DriveError("measured joint positions are not finite; nothing can be sent: restart the arm's controller")
    low, high = velocity_bounds(settings.limits, target)
    speed = np.where(step > 0.0, high, -low)
    with np.errstate(divide="ignore", invalid="ignore"):
        return float(np.max(np.where(step == 0.0, 0.0, np.abs(step) / speed)))


def check_pace(settings: ArmSettings, travel_time: float, time_left: float) -> None:
    """Refuse a target that the arm cannot reach by the next one.

    Args:
        settings: what is allowed.
        travel_time: least time to reach it, see `compute_travel_time` [s].
        time_left: time until the next target is due, at most a period and a quarter [s].

    Raises:
        DriveError: with the implied share of the speed limit.
    """
    if not travel_time <= time_left:
        share = travel_time / settings.period
        raise DriveError(
            f"arm target is {share:.3g} periods of {1e3 * settings.period:g} ms away at the joints' speed limits, "
            f"{max(time_left, 0.0) / settings.period:.3g} are left; allowed: smaller steps, at a steady rate"
        )


def check_acceleration(settings: ArmSettings, before: np.ndarray, after: np.ndarray, time: float) -> None:
    """Refuse a target that changes the speed of the targets faster than the joints accelerate.

    Where no acceleration is published, every change passes.

    Args:
        settings: what is allowed.
        before: speed from the target before the last one to the last, shape (n_arm,) [rad/s].
        after: speed from the last target to this one, same shape [rad/s].
        time: time since the last target, at least a period [s].

    Raises:
        DriveError: with joint, acceleration and what is allowed.
    """
    most = settings.limits.acceleration
    if most is None:
        return
    found = np.abs(after - before) / time
    i = _find_unfit(found <= most)
    if i is not None:
        raise DriveError(
            f"arm target of joint {i + 1} asks for {found[i]:.3g} rad/s^2; allowed: {most[i]:.3g} rad/s^2: "
            "targets whose speed changes more slowly"
        )


def check_lead(settings: ArmSettings, target: np.ndarray, measured: np.ndarray) -> None:
    """Refuse a target that is further from the measured position than the arm lags behind while it moves.

    Raises:
        DriveError: with joint, distance and what is allowed.
    """
    lead, allowed = np.abs(target - measured), settings.lead_time * np.asarray(settings.limits.velocity)
    i = _find_unfit(lead <= allowed)
    if i is not None:
        raise DriveError(
            f"arm target of joint {i + 1} is {lead[i]:.3g} rad from its measured position; allowed: {allowed[i]:.3g} "
            "rad: approach in small steps, and look whether something blocks the arm"
        )


def _find_unfit(is_fit: np.ndarray) -> int | None:
    """Index of the first joint that is not fit, of a mask of shape (n_arm,); None where all are."""
    return None if is_fit.all() else int(np.argmin(is_fit))


def read_load(load: ArmLoad, payload: float | None, tool_mass: float = 0.0) -> ArmLoad:
    """A load in arrays of floats, which a body can have and the arm may carry.

    Args:
        load: what hangs on the flange.
        payload: rated payload, None where it is unknown [kg].
        tool_mass: mass of the end effector that the controller knows already [kg].

    Raises:
        DriveError: with what was given and what is allowed.
    """
    mass = float(read_numbers("mass of the load", load.mass, shape=(), unit="kg", error=DriveError))
    center = read_numbers("centre of the load", load.center, shape=(3,), unit="m", error=DriveError)
    inertia = read_numbers("inertia of the load", load.inertia, shape=(3, 3), unit="kg m^2", error=DriveError)
    if not mass > 0.0:
        raise DriveError(f"mass of the load is {mass:g} kg; allowed: above 0")
    if not np.linalg.norm(center) <= FARTHEST_LOAD:
        raise DriveError(
            f"centre of the load is {describe(center.tolist())} m; allowed: within {FARTHEST_LOAD:g} m of the flange"
        )
    _check_inertia(inertia)
    if payload is not None and not mass + tool_mass <= payload:
        tool = f" and {tool_mass:.3g} kg of end effector set in the arm's own software" if tool_mass else ""
        raise DriveError(
            f"load of the arm is {mass:.3g} kg{tool}; allowed: {payload:g} kg in all: weigh housing and trunk and set "
            "housing.mass_kg, print lighter parts, or take an arm of a larger payload"
        )
    return ArmLoad(mass=mass, center=center, inertia=inertia)


def _check_inertia(inertia: np.ndarray) -> None:
    """Refuse what is no inertia: asymmetric, or with a principal moment above the sum of the other two."""
    size = float(np.abs(inertia).max())
    if not np.allclose(inertia, inertia.T, rtol=0.0, atol=1e-9 * size):
        raise DriveError("inertia of the load is not symmetric; allowed: one about the centre of mass")
    least, middle, most = np.linalg.eigvalsh(inertia).tolist()
    if not (least > 0.0 and most <= (least + middle) * (1.0 + 1e-6)):
        raise DriveError(
            f"principal moments of the load are {least:.3g}, {middle:.3g}, {most:.3g} kg m^2; allowed: positive, none "
            "above the sum of the other two"
        )


def _check_limits(limits: ArmLimits) -> None:
    """Refuse limits that no target can be checked against."""
    if limits.position is None or limits.velocity is None:
        missing = "position" if limits.position is None else "velocity"
        raise DriveError(f"the arm's limits of joint {missing} are unknown; allowed: limits with positions and speeds")
    velocity = read_numbers("arm velocity limit", limits.velocity, error=DriveError)
    low, high = (read_array("arm position limit", end, velocity.shape, error=DriveError) for end in limits.position)
    if velocity.ndim != 1 or velocity.size == 0 or not (velocity > 0.0).all():
        raise DriveError(f"arm velocity limit is {describe(velocity)}; allowed: one positive number a joint")
    if not (low < high).all():
        i = int(np.argmin(low < high))
        raise DriveError(
            f"positions of joint {i + 1} reach from {low[i]:g} to {high[i]:g} rad; allowed: low below high"
        )


def _count_joints(limits: ArmLimits) -> set[int]:
    """Numbers of joints of the known limits; one number where the limits agree."""
    known = [getattr(limits, name) for name in QUANTITIES]
    return {int(np.shape(limit)[-1]) for limit in known if limit is not None}


def _least(first: np.ndarray | None, second: np.ndarray | None) -> np.ndarray | None:
    return _pick(first, second) if first is None or second is None else np.minimum(first, second)


def _pick(first: _T | None, second: _T | None) -> _T | None:
    return second if first is None else first
