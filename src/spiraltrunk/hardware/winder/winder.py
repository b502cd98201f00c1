"""Control of one winder: upper limits of tension and pull become a torque, and feedback becomes pull and tension.

All functions are pure; the state is passed in and out. Nothing here was tried on a real motor.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import NamedTuple, final

from spiraltrunk.checks import check_number
from spiraltrunk.control.command_check import FARTHEST
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import DriveError
from spiraltrunk.field_docs import explain_fields
from spiraltrunk.hardware.motors.motor_port import MotorDataSheet, MotorState
from spiraltrunk.hardware.winder.dither import (
    Dither,
    can_stir,
    compute_amplitude,
    compute_sign,
    count_half,
    step_dither,
)
from spiraltrunk.hardware.winder.drum import DrumGeometry
from spiraltrunk.hardware.winder.feedback_check import check_feedback
from spiraltrunk.hardware.winder.friction import FrictionDirection, follow_motion, lead_at_rest
from spiraltrunk.hardware.winder.gains import CABLE_STIFFNESS, WinderGains, derive_gains
from spiraltrunk.hardware.winder.limits import FRICTION_SHARE, WinderLimits, build_limits
from spiraltrunk.hardware.winder.loss import LOSS_RATE, LossBounds, follow_loss, is_most
from spiraltrunk.hardware.winder.motion import MOST_PERIODS, Motion, low_pass

LET_DOWN = 0.02
"""Rate at which a set tension falls that counts as letting down, over the slew limit [-] (ours)."""

LANDING = 0.075
"""Rate at which the set tension approaches its floor from above, over the washout's [-] (ours: no slack then)."""


@final
@dataclass(frozen=True, kw_only=True)
class Winder:
    """Constants of one winder."""

    drum: DrumGeometry
    """Pull and radius against angle."""
    limits: WinderLimits
    """What it never exceeds."""
    gains: WinderGains
    """Rates of its loops."""
    inertia: float
    """Inertia of the rotor with its drum [kg m^2]."""
    friction: float
    """Dry friction of the rotor [N m]."""
    angle_step: float
    """Resolution of the angle [rad]."""
    n_half: int
    """Periods of control in half a cycle of the dither [-]."""
    can_stir: bool
    """Whether a stir shows a stuck drum."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True, slots=True)
class WinderTarget:
    """Set point of a winder, as of `spiraltrunk.control.messages.Command`."""

    tension: float
    """Upper limit of the tension, from 0 to the design's ``tension_max`` [N]; the floor holds below it."""
    pull: float = math.inf
    """Upper limit of the cable pulled in since the straight trunk [m]; infinity sets none."""


class WinderState(NamedTuple):
    """State of the control between two steps."""

    zero_angle: float
    """The motor's angle at the straight trunk [rad]."""
    motor_time: float = -math.inf
    """Time of the feedback that was last used [s]."""
    speed: float = 0.0
    """Speed of the cable then [m/s]."""
    slow_speed: float = 0.0
    """Low-pass of that, of the washout [m/s]."""
    tension_limit: float = 0.0
    """Upper limit of the tension after the slew limit [N]."""
    tension_set: float = 0.0
    """Set tension after limits and slew limit [N]."""
    slow_set: float = 0.0
    """Low-pass of that, as far as it acts: the integral part of the limit of pull [N]."""
    resistance: float = 0.0
    """Estimate of the force against winding in, tension and friction [N]."""
    tension: float = 0.0
    """Estimate of the tension [N]."""
    slow_pull: float = 0.0
    """Pull through the low-pass of that estimate [m]."""
    direction: FrictionDirection = FrictionDirection()
    """Direction of winding that dry friction opposes."""
    force: float = 0.0
    """Force that was commanded in the step before, without a dither [N]."""
    loss: float = 0.0
    """Part of that force that does not reach the cable, by a load cell [N]."""
    dither: Dither = Dither()
    """Dither, see `dither`."""


class WinderReading(NamedTuple):
    """What a winder measures."""

    pull: float
    """Cable pulled in since the straight trunk [m]."""
    speed: float
    """Its rate [m/s]."""
    tension: float
    """Tension: the load cell's where there is one, else the estimate of `step` [N]."""
    is_limited: bool
    """Whether a limit of speed, length or torque holds the winder back."""
    is_loss_most: bool = False
    """Whether the loss by a load cell stands at its bound though the drum is slow: more than friction explains."""


def build_winder(
    design: TrunkDesign,
    motor: MotorDataSheet,
    drum: DrumGeometry,
    period: float,
    *,
    stiffness: float = CABLE_STIFFNESS,
    tension_floor: float | None = None,
    friction: float | None = None,
) -> Winder:
    """Constants of one winder whose control runs every ``period`` [s] on a cable of ``stiffness`` [N/m].

    ``friction`` is the rotor's as measured [N m]; the data sheet's by default. The true one may be from half of it to
    twice as much; with less than a third, compensation makes the rotor oscillate against a stiff cable.

    Raises:
        DesignError: where the period is shorter than the motor's bus allows, or limits or gains cannot be met.
    """
    motor = motor if friction is None else replace(motor, rotor_friction=friction)
    check_number("winder.period", period, least=motor.period, below=math.inf)
    check_number("winder.friction", motor.rotor_friction, least=0.0, most=motor.torque_max)
    return Winder(
        drum=drum, limits=build_limits(design, drum, motor, tension_floor),
        gains=derive_gains(period, motor.rotor_inertia, drum.radius_max, stiffness), n_half=count_half(period),
        inertia=motor.rotor_inertia, friction=motor.rotor_friction, angle_step=motor.angle_step,
        can_stir=can_stir(period, motor.rotor_inertia, motor.rotor_friction, motor.angle_step),
    )  # fmt: skip


def check_target(target: WinderTarget, limits: WinderLimits) -> None:
    """Refuse what is no set point, before anything is clamped.

    Raises:
        DriveError: where the tension is not finite or outside 0 to the design's largest, or the pull is not a number.
    """
    most = limits.tension_max
    if not -1e-9 * most <= target.tension <= (1 + 1e-9) * most:
        raise DriveError(f"tension of a winder is {target.tension:g} N; allowed: 0 to {most:g} N, the design's largest")
    if not target.pull > -FARTHEST:
        allowed = f"metres above -{FARTHEST:g}, or infinity for no limit"
        raise DriveError(f"pull of a winder is {target.pull:g} m; allowed: {allowed}")


def step(
    winder: Winder,
    state: WinderState,
    target: WinderTarget,
    motor: MotorState,
    dt: float,
    *,
    measured_tension: float | None = None,
    dither: float | None = None,
    is_stirred: bool = False,
) -> tuple[WinderState, WinderReading, float]:
    """Advance the control by ``dt`` [s] and return its state, what was measured, and the motor's torque [N m].

    With x the pull, v its rate, m = J / r^2 the rotor's mass at the cable, and rates w of `WinderGains`:

    - the set tension s = clip(s_slow + m w_speed (v_wanted - v), floor, limit), slewed, with v_wanted = w_position
      (pull limit - x), and s_slow the low-pass of s as far as the governor lets it act: a stiffness
      of m w_speed w_position with an integral part that stops at the limits (automatic reset);
    - the force f = s - m w_damping (v - v_slow) + friction * direction, where v_slow is the low-pass of v;
    - the governor bounds f so that v stays within the speed limit and x within the soft limits of length: f <= R + m
      w_governor (v_allowed - v), with R the estimate of tension and friction, and the same from below up to the ceiling
      of the tension; a slack cable is slower than a taut one;
    - the torque f r, within the data sheet, with a dither where a cable is let down to the floor or stirred, see
      `dither`.

    T is that of a disturbance observer: torque / r - friction - m dv/dt through a first-order low-pass of
    ``w_observer`` (83 rad/s at 500 Hz), which ``slow_pull`` passes, too. While the rotor stands still T is
    uncertain by the dry friction over the radius, either way.

    With a load cell T is measured, and the loss that it tells takes the place of friction * direction, see `loss`.

    Args:
        winder: the winder's constants.
        state: state after the step before.
        target: set point.
        motor: latest feedback of its motor; one that was seen before leaves the estimates as they are.
        dt: time since the step before [s].
        measured_tension: tension by a load cell [N]; None without one.
        dither: amplitude over the dry friction [-], in place of any compensation, as in homing; None for the winder's.
        is_stirred: whether a stir starts, where the winder can, see `dither`.

    Raises:
        DriveError: where target, feedback, ``dt`` or the measured tension is not finite or out of its range.
    """
    check_target(target, winder.limits)
    check_feedback(motor, dt, measured_tension)
    motion = _read_motion(winder, state, motor, dt)
    resistance, tension, slow_pull, direction = _observe(winder, state, motor, motion)
    felt = tension if measured_tension is None else max(measured_tension, 0.0)
    limit, wanted = _set_tension(winder, state, target, motion)
    if not motion.is_turning:
        falls = wanted - state.tension_set < -1e-3 * winder.limits.tension_slew * motion.dt
        direction = lead_at_rest(direction, motion.dt, is_let_down=falls)
    speed, gains = motion.speed, winder.gains
    slow_speed = state.slow_speed + low_pass(gains.washout * motion.dt) * (speed - state.slow_speed)
    shaken = _step_dither(winder, state, wanted, motion, is_stirred=is_stirred)
    friction = FRICTION_SHARE * winder.friction / motion.radius
    loss = None if measured_tension is None else _follow_loss(winder, state, motor, motion, measured_tension)
    compensated = 0.0
    if dither is None:
        dither = compute_amplitude(shaken, (wanted - winder.limits.tension_floor) * motion.radius, winder.friction)
        compensated = max(1.0 - dither, 0.0) * friction * direction.share
    force = _drag(winder.limits, wanted, speed) - motion.mass * gains.damping * (speed - slow_speed)
    if loss is None:
        force += max(compensated, winder.limits.tension_floor - wanted)  # Letting down ends with the rotor braked.
    else:
        force += loss
    force = min(force, winder.limits.tension_ceiling + max(winder.friction / motion.radius, loss or 0.0))
    governed = _govern(winder, force, _allow_speeds(winder, target.pull, wanted, felt, motion), resistance, motion)
    torque_max = winder.limits.torque_max
    torque = governed * motion.radius + dither * winder.friction * compute_sign(shaken, winder.n_half)
    torque = min(max(torque, -torque_max), torque_max)
    slow_set = state.slow_set + low_pass(gains.reset * motion.dt) * (wanted + governed - force - state.slow_set)
    after = WinderState(
        zero_angle=state.zero_angle, motor_time=motor.time, speed=speed, slow_speed=slow_speed, tension_limit=limit,
        tension_set=wanted, slow_set=slow_set, resistance=resistance, tension=tension, slow_pull=slow_pull,
        direction=direction, force=governed, loss=loss or 0.0, dither=shaken,
    )  # fmt: skip
    is_limited = governed != force or abs(torque) == torque_max
    is_loss_most = loss is not None and abs(speed) < gains.slack_speed and is_most(loss, _bound_loss(winder, motion))
    return after, WinderReading(motion.pull, speed, felt, is_limited, is_loss_most), torque


def _read_motion(winder: Winder, state: WinderState, motor: MotorState, dt: float) -> Motion:
    angle = motor.angle - state.zero_angle
    radius = winder.drum.radius(angle)
    is_turning = abs(motor.speed) > winder.angle_step / winder.gains.period
    dt = min(dt, MOST_PERIODS * winder.gains.period)
    return Motion(winder.drum.pull(angle), motor.speed * radius, radius, winder.inertia / radius**2, dt, is_turning)


def _find_since(winder: Winder, state: WinderState, motor: MotorState, motion: Motion) -> float:
    """Time between two frames of feedback, without jumps [s]."""
    return min(max(motor.time - state.motor_time, motion.dt / 2), MOST_PERIODS * winder.gains.period)


def _observe(
    winder: Winder, state: WinderState, motor: MotorState, motion: Motion
) -> tuple[float, float, float, FrictionDirection]:
    """Estimates of resistance and tension [N], the pull as late as these [m], and direction that friction opposes."""
    if motor.time <= state.motor_time:
        return state.resistance, state.tension, state.slow_pull, state.direction
    torque_force = motor.torque / motion.radius
    if state.motor_time == -math.inf:
        return torque_force, max(torque_force, 0.0), motion.pull, FrictionDirection(0.0, motor.angle)
    direction = follow_motion(state.direction, motor.angle, winder.angle_step)
    since = _find_since(winder, state, motor, motion)
    now = torque_force - motion.mass * (motion.speed - state.speed) / since
    share = low_pass(winder.gains.observer * since)
    tension = state.tension + share * (now - winder.friction / motion.radius * direction.share - state.tension)
    slow_pull = state.slow_pull + share * (motion.pull - state.slow_pull)
    return state.resistance + share * (now - state.resistance), max(tension, 0.0), slow_pull, direction


def _set_tension(winder: Winder, state: WinderState, target: WinderTarget, motion: Motion) -> tuple[float, float]:
    """Upper limit of the tension, and the set tension, both after the slew limit [N]."""
    limits, gains = winder.limits, winder.gains
    slew = limits.tension_slew * motion.dt
    asked = min(max(target.tension, limits.tension_floor), limits.tension_ceiling)
    limit = _follow(state.tension_limit, asked, slew)
    wanted_speed = max(gains.position * (target.pull - motion.pull), -limits.speed_max)
    held = state.slow_set + motion.mass * gains.speed * (wanted_speed - motion.speed)
    wanted = max(min(held, limit), limits.tension_floor)
    landing = LANDING * gains.washout * motion.dt * (state.tension_set - limits.tension_floor)
    lowest = state.tension_set - min(slew, max(landing, 0.0))
    return limit, max(_follow(state.tension_set, wanted, slew), lowest)


def _follow(before: float, wanted: float, most: float) -> float:
    return min(max(wanted, before - most), before + most)


def _step_dither(winder: Winder, state: WinderState, wanted: float, motion: Motion, *, is_stirred: bool) -> Dither:
    """Dither that starts while the set tension falls faster than `LET_DOWN` of its slew limit."""
    falls = state.tension_set - wanted > LET_DOWN * winder.limits.tension_slew * motion.dt
    is_stirred = is_stirred and winder.can_stir
    return step_dither(state.dither, motion.pull, motion.dt, winder.n_half, is_let_down=falls, is_stirred=is_stirred)


def _follow_loss(winder: Winder, state: WinderState, motor: MotorState, motion: Motion, measured: float) -> float:
    """Loss by the load cell [N], see `loss.follow_loss`; feedback that was seen before leaves it as it is."""
    if motor.time <= state.motor_time or state.motor_time == -math.inf:
        return state.loss
    since = _find_since(winder, state, motor, motion)
    loss = state.force - motion.mass * (motion.speed - state.speed) / since - measured
    share = low_pass(LOSS_RATE * winder.gains.observer * since)
    return follow_loss(state.loss, loss, measured, share, _bound_loss(winder, motion))


def _bound_loss(winder: Winder, motion: Motion) -> LossBounds:
    limits = winder.limits
    return LossBounds(winder.friction / motion.radius, limits.tension_floor, limits.tension_ceiling)


def _drag(limits: WinderLimits, wanted: float, speed: float) -> float:
    """The set tension less the drag of winding, though not below the floor, or plus that of paying out [N]."""
    dragged = wanted - limits.drag * speed
    return max(dragged, limits.tension_floor) if speed > 0.0 else min(dragged, limits.tension_ceiling)


def _allow_speeds(
    winder: Winder, pull_limit: float, wanted: float, tension: float, motion: Motion
) -> tuple[float, float]:
    """Largest speed of winding in and, negative, of paying out [m/s].

    Both vanish at the soft limits of length. The limit of pull is passed slowly, and only at the floor as fast as a
    slack cable is taken in.
    """
    limits, gains = winder.limits, winder.gains
    fastest = min(gains.slack_speed + tension / limits.drag, limits.speed_max)
    passing = gains.slack_speed * limits.tension_floor / max(wanted, limits.tension_floor)
    into = min(fastest, passing + max(gains.position * (pull_limit - motion.pull), 0.0))
    stop_in = gains.position * (limits.pull_max - motion.pull)
    stop_out = gains.position * (limits.pull_min - motion.pull)
    return max(min(stop_in, into), -fastest), min(max(stop_out, -fastest), fastest)


def _govern(winder: Winder, force: float, speeds: tuple[float, float], resistance: float, motion: Motion) -> float:
    """The force that keeps the speed within the largest ones [N]."""
    damping = motion.mass * winder.gains.governor
    most = resistance + damping * (speeds[0] - motion.speed)
    least = resistance + damping * (speeds[1] - motion.speed)
    strongest = winder.limits.tension_ceiling + winder.friction / motion.radius
    return max(min(force, most), min(least, strongest))
