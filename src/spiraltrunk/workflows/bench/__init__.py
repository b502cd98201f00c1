"""Performance claims, each a ratio of two things measured in one run."""

from __future__ import annotations

from collections.abc import Callable

from spiraltrunk.workflows.bench.bending import measure_bend_batch, measure_bend_single
from spiraltrunk.workflows.bench.claim import Claim
from spiraltrunk.workflows.bench.elastica import check_elastica, measure_rest_pyelastica
from spiraltrunk.workflows.bench.equilibrium import measure_statics_mujoco
from spiraltrunk.workflows.bench.grasp import measure_grasp_real_time
from spiraltrunk.workflows.bench.reach import measure_inverse_least_squares, measure_inverse_success
from spiraltrunk.workflows.bench.rest import measure_rest_fsolve, measure_rest_mujoco

__all__ = ["CLAIMS", "PEERS", "Claim", "check_peers"]

CLAIMS: dict[str, Callable[[], Claim]] = {
    "grasp_real_time": measure_grasp_real_time,
    "rest_mujoco": measure_rest_mujoco,
    "rest_fsolve": measure_rest_fsolve,
    "bend_single": measure_bend_single,
    "bend_batch": measure_bend_batch,
    "statics_mujoco": measure_statics_mujoco,
    "inverse_least_squares": measure_inverse_least_squares,
    "inverse_success": measure_inverse_success,
}
"""How each claim is measured."""

PEERS: dict[str, Callable[[], Claim]] = {"rest_pyelastica": measure_rest_pyelastica}
"""The same for claims that need the packages of the extra ``peers``."""

check_peers = check_elastica
"""Raises `MissingPackage` where one of them is not installed."""
