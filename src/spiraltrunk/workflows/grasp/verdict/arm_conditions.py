"""Conditions on the arm: its limits, from its simulated motion and its commands."""

from __future__ import annotations

import numpy as np

from spiraltrunk.control.arm_limits import velocity_bounds
from spiraltrunk.workflows.grasp.verdict.evidence import Evidence

Condition = tuple[bool, str]


def arm_conditions(evidence: Evidence) -> list[Condition]:
    """Whether each known limit was kept; what has no limit yields no condition: `find_missing_limits` names it."""
    return [(not passed.any(), f"the arm passed {what}") for what, passed in find_passed_limits(evidence)]


def find_passed_limits(evidence: Evidence) -> list[tuple[str, np.ndarray]]:
    """For each known limit of the arm, whether it was passed at each sample, shape (n_sample,).

    Speed and torque as simulated; acceleration and jerk of the commanded path at the rate of its commands. A torque at
    its limit counts as passed, as simulated actuators, like real ones, give no more.
    """
    trace, limits = evidence.trace, evidence.limits
    if len(trace) < 2:
        return []
    dt = trace[1].time - trace[0].time
    position, velocity, torque, command = (
        np.array([getattr(s, name) for s in trace])
        for name in ("arm_position", "arm_velocity", "arm_torque", "arm_command")
    )
    passed = []
    if limits.velocity is not None:
        passed.append(("its speed limit", ~_is_within(velocity, velocity_bounds(limits, position))))
    if limits.torque is not None:
        passed.append(("its torque limit", ~(np.abs(torque) < limits.torque).all(axis=1)))
    for order, name, most in ((2, "acceleration", limits.acceleration), (3, "jerk", limits.jerk)):
        if most is not None:
            within = _is_within(np.diff(command, order, axis=0) / dt**order, (-most, most))
            passed.append((f"its {name} limit", np.append(np.zeros(min(order, len(trace)), bool), ~within)))
    if limits.position is not None:
        passed.append(("a joint range", ~_is_within(position, limits.position)))
    return passed


def _is_within(values: np.ndarray, bounds: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
    return np.asarray(((values >= bounds[0]) & (values <= bounds[1])).all(axis=1))
