"""Limits of the watches: from when on a measurement is a fault."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields, replace
from typing import final

from spiraltrunk.checks import check_number
from spiraltrunk.field_docs import explain_fields

_SLACK_TIMES = 4.7
"""Least `SafetyLimits.settle_time` over the time in which a slack cable comes in by `SafetyLimits.step_length` [-]
(ours: that of a GM6020)."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class SafetyLimits:
    """When a watch raises a fault. All numbers are ours unless a source is named; none was tried on a real motor."""

    command_age: float = 0.020
    """Largest age of a command after its validity ended [s]."""
    feedback_age: float = 0.050
    """Largest age of a motor's or the arm's feedback [s]; half a turn of a GM6020 takes 94 ms at full speed."""
    missed_cycles: int = 20
    """Periods of control in a row without new feedback of a motor [-] (Franka's control interface stops after 20)."""
    loss_warned: float = 0.05
    """Part of the feedback that is lost from which the driver warns [-]."""
    loss_stopped: float = 0.20
    """Part of the feedback that is lost at which the driver stops [-]."""
    loss_evidence: float = 14.0
    """Log-likelihood ratio of `loss_stopped` against `loss_warned` at which the driver stops [-].

    Three motors at 1 kHz: 33 ms after the loss rose to `loss_stopped` on the average, and falsely once in 2.7 hours of
    a constant loss of `loss_warned` (average run lengths from the Markov chain of the sum)."""
    late_most: float = 0.020
    """Longest time for which frames that may have been delayed are waited for before they count as an outage [s]."""
    loss_memory: float = 1.0
    """Time constant of the mean loss that is shown and warned of [s]."""
    frozen_frames: int = 10
    """Equal new frames after the commanded torque has changed that are a fault [-]."""
    frozen_torque: float = 0.03
    """Change of the commanded torque that every motor's own estimate must show [N m]: 3 N on a drum of 10 mm."""
    frozen_still: int = 100
    """Equal new frames under whatever torque that are a fault, of a motor whose last digit fluctuates at rest [-]."""
    blocked_torque: float = 0.12
    """Change of the commanded torque, beyond dry friction both ways, that must turn the drum [N m]: 12 N on 10 mm."""
    blocked_frictions: float = 3.6
    """The same change over the dry friction, where that is more [-]: friction both ways, what is compensated of it, and
    as much again."""
    blocked_steps: float = 3.0
    """Turn that counts as none, in steps of the encoder [-]."""
    blocked_memory: float = 1.0
    """Time constant with which torques of before are forgotten while other drums explain their change [s]: while all
    tensions rise slowly, a drum may stand for seconds between friction and the trunk's motion."""
    blocked_motion: float = 5e-5
    """Cable that other drums move within that time that explains it [m]: 1 N of a winder's cable."""
    blocked_motion_most: float = 0.02
    """Cable that none of them may move within that time to explain it [m]: so far they bend the trunk, which takes
    every taut cable along."""
    blocked_time: float = 0.2
    """Time for which the drum does not turn after that change [s]."""
    stall_part: float = 0.9
    """Part of the motor's largest torque at which it is saturated [-]."""
    stall_time: float = 0.5
    """Time of saturation without motion that is a fault [s]."""
    stall_speed: float = 0.2
    """Speed below which a saturated motor stands [rad/s]; a GM6020 resolves 0.1 rad/s."""
    speed_window: float = 0.05
    """Time over which the change of the angle is compared with the speed [s]."""
    speed_error: float = 0.3
    """Largest difference of angle and integrated speed in that time [rad]: 6 rad/s."""
    speed_error_part: float = 0.5
    """The same as a part of the integrated speed, for motors whose speed is filtered [-]."""
    jump_speeds: float = 1.5
    """Change of the angle between two frames over what full speed allows that is a jump [-]."""
    jump_angle: float = 0.1
    """Change of the angle that is no jump, however short the time [rad]."""
    swap_torque: float = 0.02
    """Mean misfit of torques by which exchanged feedback must explain more than that of the right motor [N m]."""
    swap_impulse: float = 0.01
    """Integral of the misfit beyond that at which feedback counts as exchanged [N m s]."""
    temperature_least: float = -40.0
    """Least plausible temperature [degC]."""
    temperature_most: float = 150.0
    """Largest plausible temperature [degC]."""
    voltage_least: float = 0.0
    """Least supply voltage [V]; a robot file of STS servos sets 0.8 times the nominal one."""
    voltage_most: float = 100.0
    """Largest supply voltage [V]; a robot file of STS servos sets 1.2 times the nominal one."""
    voltage_time: float = 0.1
    """Time for which the voltage may be outside [s]."""
    slack_part: float = 0.5
    """Part of the least nominal load under which a cable carries none [-]."""
    slack_memory: float = 0.02
    """Time constant of the mean load that is compared with it [s]."""
    slack_time: float = 0.04
    """Least time without load of a cable that counts as slack or broken when lengths do not fit [s]."""
    step_length: float = 0.003
    """Length that no bend explains, wound in within `settle_time`, that counts as a slip or a break [m]."""
    settle_time: float = 0.5
    """Time constant of the low-pass of the taut cables' lengths [s]: a slip is a step against it. It is longer for
    winders that take in slack slowly, see `adapt_to_slack_speed`."""
    settle_least: float = 0.001
    """Largest length below that of an even bend that counts as an error of homing [m]; more counts as slack."""
    untaken_length: float = 0.01
    """Slack, as length below that of an even bend, that a drum must take in within `stall_time` [m]."""
    untaken_speed: float = 0.001
    """Speed of winding in above which a drum takes in slack [m/s]; a GM6020 resolves 1.9 mm/s on a drum of 18 mm."""
    compliance: float = 5e-5
    """Cable wound in over the tension that is elastic [m/N]: that of a winder's cable of 20 kN/m. From none to twice as
    much is allowed for, because a trunk shortens, too."""
    slip_length: float = 0.003
    """Cable wound in while the tension dips that is a slip [m]."""
    slip_tension: float = 3.0
    """Least dip of tension that is a slip [N]."""
    slip_part: float = 0.5
    """Dip over the tension before it [-]."""
    slip_rate: float = 300.0
    """Fall of tension that is no dip [N/s]: 1.25 times the largest of the commands, 240 N/s."""
    slip_time: float = 0.15
    """Longest time from the dip to the burst [s]."""
    tangle_length: float = 0.003
    """Cable paid out while the tension rises that is a tangle [m]."""
    tangle_tension: float = 15.0
    """Rise of the tension that is a tangle, above its value at the start, its command, the winder's drag and friction
    [N]."""
    tangle_drive: float = 3.0
    """Force with which a cable drives a drum in that tells a tangled drum from a slip or a break [N]."""
    tangle_speed: float = 0.01
    """Speed of winding in above which that force is looked at [m/s]: before, dry friction changes its sense."""
    over_part: float = 0.15
    """Tension beyond its ceiling, as a part of it [-]."""
    over_time: float = 0.03
    """Time for which it may be beyond [s]."""
    over_part_at_once: float = 0.5
    """Tension beyond its ceiling, as a part of it, that is a fault at once [-]."""
    cell_still: float = 0.5
    """Time for which a load cell may tell the same number [s]: the last digits of its amplifier fluctuate."""
    cell_frictions: float = 1.5
    """Dry friction over the assumed one by which a load cell and the motor may differ [-]; `cell_part` allows for more
    where the friction is larger."""
    cell_error: float = 3.0
    """Error of a load cell's zero that is allowed [N]."""
    cell_part: float = 0.25
    """Error of a load cell's scale, or of the motor's torque, that is allowed [-]."""
    cell_time: float = 0.2
    """Time for which a load cell and the motor may differ by more [s]: the estimate lags behind by up to 60 ms."""
    cell_beyond: float = 0.5
    """Time for which a load cell may ask a winder with a slow drum for more force than friction explains, or tell of a
    slack cable that bends the trunk [s]."""
    cell_bent: float = 0.001
    """Cable wound in without slack to take in while its load cell tells of no load that is a fault of the cell [m]."""
    cell_loosened: float = 2.5e-4
    """Slack that the lengths may tell of meanwhile [m]."""
    length_margin: float = 0.005
    """Length beyond its limits that is a fault [m]; the winder itself stops at the limits."""

    def __post_init__(self) -> None:
        for field in fields(self):
            least = -273.15 if field.name == "temperature_least" else 0.0
            check_number(f"safety.{field.name}", getattr(self, field.name), least=least, below=1e6)
        check_number("safety.loss_warned", self.loss_warned, above=0.0, below=self.loss_stopped)
        check_number("safety.loss_stopped", self.loss_stopped, below=1.0)


def adapt_to_slack_speed(limits: SafetyLimits, slack_speed: float, lag: float = 0.0) -> SafetyLimits:
    """Limits for winders that take in slack no faster than ``slack_speed`` [m/s], where that is slow.

    What slipped comes in at that speed v, is seen with the ``lag`` d of the tension's estimate [s], and lengths are
    followed meanwhile: with the time constant t, the length x that came in has become
    ``v t (1 - exp(-(x / v - d) / t))``. The limit is that when x is `SafetyLimits.step_length`, with a t of
    `_SLACK_TIMES` times ``step_length / v``: 0.90 ``step_length`` without a lag.
    """
    duration = limits.step_length / slack_speed
    settle_time = _SLACK_TIMES * duration
    if settle_time <= limits.settle_time:
        return limits
    share = -_SLACK_TIMES * math.expm1((lag / duration - 1.0) / _SLACK_TIMES)
    return replace(limits, settle_time=settle_time, step_length=share * limits.step_length)
