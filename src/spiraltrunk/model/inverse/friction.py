"""Inverse with friction: loading paths for many targets, each searched on its own."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from spiraltrunk.checks import check_number
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import ModelError
from spiraltrunk.model.inverse.friction_starts import get_friction_starts
from spiraltrunk.model.inverse.multistart import InverseOptions, LoadCases, round_case
from spiraltrunk.model.inverse.path_search import Goal, search_path
from spiraltrunk.model.inverse.staged_loading import StagedLoading
from spiraltrunk.model.jit import share
from spiraltrunk.model.kinematics.shape import Shape
from spiraltrunk.model.statics.loading_path import LoadingPath, load_along
from spiraltrunk.model.statics.loads import Loads

_SEARCHED = 1e-7
"""Largest residual moment during the search [N m]; it moves the tip by some micrometres."""


def read_friction(design: TrunkDesign, friction: float | None, options: InverseOptions) -> float:
    """The coefficient of friction, None for the design's [-].

    Raises:
        DesignError: where it is out of range.
        ModelError: where quasi-static loading is asked for, which the search with friction does not use.
    """
    mu = design.cable.friction if friction is None else friction
    check_number("friction", mu, least=0.0, below=2.0)
    if mu > 0 and options.statics.quasi_static is not None:
        raise ModelError("options.statics.quasi_static is given; allowed with friction: None, loading in increments")
    return float(mu)


def solve_with_friction(
    design: TrunkDesign,
    load_cases: LoadCases,
    goals: list[Goal],
    friction: float,
    options: InverseOptions,
    *,
    batch: tuple[int, ...],
) -> tuple[Shape, LoadingPath]:
    """The equilibrium nearest to each target, and the loading path that leads to it, with the batch's axes."""
    found: list[Any] = [None] * len(goals)
    model = replace(options.statics, tolerance=max(options.statics.tolerance, _SEARCHED))
    limits = (options.tries, options.rounds, options.tolerance)

    def search(first: int, last: int) -> None:
        for b in range(first, last):
            case = load_cases.cases[b]
            starts = get_friction_starts(design, round_case(case), friction, options.statics)
            loading = StagedLoading(design, case, friction, model)
            best = search_path(loading, starts, goals[b], limits)
            found[b] = loading.build_path(best.values, best.cables, best.pull)

    share(search, len(goals), 1)
    path = LoadingPath(
        **{
            name: np.stack([getattr(one, name) for one in found]).reshape(*batch, design.n_cable)
            for name in ("order", "pull", "tension", "by_tension")
        }
    )
    shape = load_along(
        design, path, theta_0=load_cases.theta_0.reshape(batch), roll=load_cases.roll.reshape(batch),
        loads=_reshape_loads(load_cases.loads, batch), friction=friction, options=options.statics,
    )  # fmt: skip
    return shape, path


def _reshape_loads(loads: Loads, batch: tuple[int, ...]) -> Loads:
    """Loads of rows, with the batch's axes."""
    mass, force = np.asarray(loads.mass), loads.force
    return replace(
        loads,
        mass=mass.reshape(batch) if mass.ndim else mass,
        force=None if force is None else np.reshape(force, (*batch, 3)),
    )
