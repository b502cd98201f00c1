"""A rod of 50 elements like the trunk, relaxed in PyElastica."""

from __future__ import annotations

import math
import time
from typing import Any

import numpy as np

from spiraltrunk.design import presets
from spiraltrunk.design.rules import GRAVITY
from spiraltrunk.errors import MissingPackage
from spiraltrunk.workflows.bench.claim import Claim, time_in_turns
from spiraltrunk.workflows.bench.rest import rest_in_turn

ELEMENTS = 50
"""Elements of the rod."""

CLOSE = 1e-3
"""Distance from the final shape at which the rod counts as at rest, over its length [-]."""

STEP = 6e-4
"""Time step [s]: the largest stable one of 0.4 to 0.8 ms."""

DAMPING = 12.0
"""Damping per mass [1/s]: of 4 to 20 the one with the shortest time to rest."""

SWING = 4.0
"""Time simulated [s]; it is at rest after 1.2."""

TURNS = 6
"""Interleaved runs of each side."""

LOOK = 0.018
"""Simulated time between two samples [s]."""


def measure_rest_pyelastica() -> Claim:
    """One shape at rest against PyElastica's rod, damped until it stays within 0.1 % of its length [s].

    The rod is simulated beyond that; the wall time until it stays close counts. Both are timed in interleaved runs, and
    the fastest of each counts.

    Raises:
        MissingPackage: where PyElastica is not installed.
    """
    check_elastica()
    ours, other = math.inf, math.inf
    for _ in range(TURNS):
        ours = min(ours, *time_in_turns(rest_in_turn()))
        seen, walls = swing()
        away = np.linalg.norm(seen - seen[-1], axis=1).max(axis=1)
        first = len(away) - int(np.argmax(away[::-1] > CLOSE * presets.PAPER.length))
        other = min(other, walls[first])
    return Claim(ours=ours, other=other, bar=10_000.0)


def check_elastica() -> None:
    """Check that PyElastica is installed.

    Raises:
        MissingPackage: where it is not.
    """
    try:
        import elastica  # noqa: F401
    except ImportError:
        raise MissingPackage(
            "PyElastica is not installed; the extra peers has it: pip install 'spiraltrunk[peers]'"
        ) from None


def swing() -> tuple[np.ndarray, list[float]]:
    """Nodes at every sample, shape (n_sample, 3, ELEMENTS + 1) [m], and the wall time until then [s]."""
    from elastica import PositionVerlet

    simulator, rod = build_rod()
    stepper = PositionVerlet()
    now = stepper.step(simulator, np.float64(0.0), np.float64(STEP))  # Compiled before the clock starts.
    seen, walls = [], []
    began = time.perf_counter()
    for _ in range(round(SWING / LOOK)):
        for _ in range(round(LOOK / STEP)):
            now = stepper.step(simulator, now, np.float64(STEP))
        walls.append(time.perf_counter() - began)
        seen.append(rod.position_collection.copy())
    return np.array(seen), walls


def build_rod() -> tuple[Any, Any]:
    """The simulator and its rod: clamped, horizontal, with length, stiffness and mass distribution of the trunk."""
    import elastica as ea

    design = presets.PAPER
    along = (np.arange(ELEMENTS) + 0.5) / ELEMENTS * design.length
    at = np.cumsum(design.section_length) - design.section_length / 2
    radius = np.interp(along, at, design.section_radius)
    stiffness = float(design.joint_stiffness[0] * design.section_length[0])
    weight = np.interp(along, at, design.section_mass / design.section_length) / (math.pi * radius**2)

    class Simulator(ea.BaseSystemCollection, ea.Constraints, ea.Forcing, ea.Damping):  # type: ignore[misc]
        """The rod and its loads."""

    simulator = Simulator()
    axes = np.eye(3)
    rod = ea.CosseratRod.straight_rod(
        ELEMENTS, np.zeros(3), axes[0], axes[1], design.length, radius, weight,
        youngs_modulus=stiffness / (math.pi * design.solid.radius**4 / 4),
    )  # fmt: skip
    simulator.append(rod)
    simulator.constrain(rod).using(ea.OneEndFixedBC, constrained_position_idx=(0,), constrained_director_idx=(0,))
    simulator.add_forcing_to(rod).using(ea.GravityForces, acc_gravity=-GRAVITY * axes[1])
    simulator.dampen(rod).using(ea.AnalyticalLinearDamper, uniform_damping_constant=DAMPING, time_step=STEP)
    simulator.finalize()
    return simulator, rod
