"""Verdict on a run that may have tried several strategies: on its last try, and on the robot over the whole run."""

from __future__ import annotations

import math
from dataclasses import replace

from spiraltrunk.control.loop import RunLog
from spiraltrunk.sim.machine import SimMachine
from spiraltrunk.workflows.grasp.choice.auto import Attempt, AutoState
from spiraltrunk.workflows.grasp.choice.candidates import Candidate
from spiraltrunk.workflows.grasp.verdict.arm_conditions import arm_conditions
from spiraltrunk.workflows.grasp.verdict.cause import Cause, Failure
from spiraltrunk.workflows.grasp.verdict.evidence import Evidence
from spiraltrunk.workflows.grasp.verdict.faults import fault_conditions, find_failure
from spiraltrunk.workflows.grasp.verdict.grasp_verdict import Verdict
from spiraltrunk.workflows.grasp.verdict.jobs import JOBS
from spiraltrunk.workflows.grasp.verdict.moments import Moments


def evaluate(plant: SimMachine, log: RunLog, job: str) -> Verdict:
    """Verdict on a run; where it tried several strategies, on the last try.

    A fault of an earlier try, such as a joint that bent too far, fails the run all the same.
    """
    evidence, attempts = Evidence.from_run(plant, log), list_attempts(log)
    if is_refused(log):
        return replace(JOBS[job](evidence), failure=Failure(cause=Cause.REFUSED, time=0.0))
    if len(attempts) < 2:
        return JOBS[job](evidence)
    verdict = JOBS[job](_last_try(evidence, log, attempts[-1]))
    whole = replace(evidence, gave_up=None)
    reason = next((text for holds, text in (*fault_conditions(whole), *arm_conditions(whole)) if not holds), None)
    if not verdict.success or reason is None:
        return verdict
    failure = find_failure(whole, Failure(cause=Cause.UNKNOWN, time=math.inf))
    return replace(verdict, success=False, reason=f"in an earlier try {reason}", failure=failure)


def _last_try(evidence: Evidence, log: RunLog, last: Attempt) -> Evidence:
    """Trace, moments and task from the start of the last try on."""
    first = next((i for i, seen in enumerate(log.observations) if seen.time >= last.began - 1e-9), 0)
    own = replace(log, observations=log.observations[first:], statuses=log.statuses[first:])
    trace = evidence.between((last.began, math.inf))
    return replace(evidence, trace=trace, task=last.task, moments=Moments.from_log(own))


def is_refused(log: RunLog) -> bool:
    """Whether a run that chose its strategy found none that can take the object, so that nothing moved."""
    return isinstance(log.state, AutoState) and not log.state.attempts


def list_attempts(log: RunLog) -> tuple[Attempt, ...]:
    """Tries of a run that chose its strategy; none for another."""
    return log.state.attempts if isinstance(log.state, AutoState) else ()


def list_candidates(log: RunLog) -> tuple[Candidate, ...] | None:
    """The ranking before anything moved, of a run that chose its strategy; None for another."""
    return log.state.candidates if isinstance(log.state, AutoState) else None
