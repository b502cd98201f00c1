"""Faults of a trial, whatever happens to the object: of the simulation, of joints and contacts, of the arm."""

from __future__ import annotations

import math

import numpy as np

from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.workflows.grasp.verdict.arm_conditions import Condition, find_passed_limits
from spiraltrunk.workflows.grasp.verdict.cause import Cause, Failure
from spiraltrunk.workflows.grasp.verdict.evidence import Evidence

BEND_MOST = math.radians(33.0)
"""Largest bend that a joint of the paper's 30 deg may show; 10 % over the limit for other designs [rad] (ours)."""

PENETRATION_MOST = 0.005
"""Deepest overlap of two bodies that counts as contact and not as fault [m] (ours)."""


def fault_conditions(evidence: Evidence) -> list[Condition]:
    """Conditions of every job: no fault of the simulation, no joint bent too far, no touch of the arm."""
    trace, warnings = evidence.trace, evidence.warnings
    penetration, bend = (float(np.max([getattr(s, name) for s in trace])) for name in ("penetration", "bend_most"))
    return [
        (warnings == 0, f"the solver warned {warnings} times"),
        (evidence.gave_up is None, f"{evidence.gave_up}"),
        (bend <= compute_bend_most(evidence.task.design), f"a joint bent {math.degrees(bend):.1f} deg"),
        (penetration <= PENETRATION_MOST, f"bodies overlapped by {penetration * 1e3:.1f} mm"),
        (not any(s.touches_robot for s in trace), "the object touched housing or arm"),
        (not any(s.arm_touches_ground for s in trace), "housing or arm touched the ground"),
    ]


def find_failure(evidence: Evidence, loss: Failure) -> Failure:
    """What went wrong first: what happened to the object, ``loss``, or a fault of the trial."""
    if evidence.warnings:
        return Failure(cause=Cause.FAULT, time=evidence.trace[-1].time)
    return min((*_find_faults(evidence), loss), key=lambda failure: failure.time)


def _find_faults(evidence: Evidence) -> list[Failure]:
    """When each fault first came."""
    trace, bend_most = evidence.trace, compute_bend_most(evidence.task.design)
    masks = [
        (Cause.COLLIDED, np.array([s.touches_robot or s.arm_touches_ground for s in trace])),
        (Cause.OVERLOADED, np.array([not s.bend_most <= bend_most for s in trace])),
        (Cause.OVERLOADED, np.array([not s.penetration <= PENETRATION_MOST for s in trace])),
        *((Cause.ARM_LIMIT, passed) for _, passed in find_passed_limits(evidence)),
    ]
    return [Failure(cause=cause, time=trace[int(np.argmax(mask))].time) for cause, mask in masks if mask.any()]


def compute_bend_most(design: TrunkDesign) -> float:
    """Largest bend that a joint may show: `BEND_MOST`, or as much more than another design's limit [rad]."""
    return design.joint_limit * BEND_MOST / math.radians(30.0)
