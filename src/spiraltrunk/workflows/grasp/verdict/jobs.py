"""Jobs of strategies, and what counts as success in each."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from spiraltrunk.workflows.grasp.verdict.evidence import Evidence
from spiraltrunk.workflows.grasp.verdict.grasp_verdict import Verdict, evaluate_grasp
from spiraltrunk.workflows.grasp.verdict.push_verdict import evaluate_kick, evaluate_sweep

JOBS: Mapping[str, Callable[[Evidence], Verdict]] = {
    "grasp": evaluate_grasp,
    "kick": evaluate_kick,
    "sweep": evaluate_sweep,
}
"""Every job that a strategy may have, and its verdict."""
