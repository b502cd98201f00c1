"""Inverse with friction: an equilibrium and its loading path for each target, each searched on its own.

`staged_loading` is the forward model, `friction_starts` the table of starts, `path_search` the search; the path found
is replayed by `load_along` of `model.statics`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import is_dataclass, replace
from typing import Any

import numpy as np

from spiraltrunk.checks import check_number
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import ModelError
from spiraltrunk.model.inverse.friction_starts import get_friction_starts
from spiraltrunk.model.inverse.multistart import InverseOptions, LoadCases, round_case
from spiraltrunk.model.inverse.path_search import Found, Goal, refine_path, search_path
from spiraltrunk.model.inverse.staged_loading import StagedLoading
from spiraltrunk.model.inverse.start_table import LoadCase, section_axes
from spiraltrunk.model.jit import share
from spiraltrunk.model.kinematics.shape import Shape
from spiraltrunk.model.statics.loading_path import LoadingPath, load_along

_SEARCHED = 1e-7
"""Largest residual moment during the search [N m]; it moves the tip by some micrometres."""

_DIFFERS = 2.0
"""Residual of the replay over the search's above which the replay counts as another equilibrium [-]."""


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

    def search(first: int, last: int) -> None:
        for b in range(first, last):
            found[b] = _search_row(design, load_cases.cases[b], goals[b], friction, options)

    share(search, len(goals), 1)
    shapes, paths = zip(*found, strict=True)
    return _stack(shapes, batch), _stack(paths, batch)


def _search_row(
    design: TrunkDesign, case: LoadCase, goal: Goal, friction: float, options: InverseOptions
) -> tuple[Shape, LoadingPath]:
    """Equilibrium and loading path of one target, as `load_along` replays it.

    Where the replay, whose residual moment is smaller than the search's, ends away from the target, the path is refined
    with the replay's.
    """
    starts = get_friction_starts(design, round_case(case), friction, options.statics)
    model = replace(options.statics, tolerance=max(options.statics.tolerance, _SEARCHED))
    loading, limits = StagedLoading(design, case, friction, model), (options.tries, options.rounds, options.tolerance)
    best = search_path(loading, starts, goal, limits)
    shape, path, left = _replay(loading, best, case, goal, options)
    if left > max(options.tolerance, _DIFFERS * best.norm):
        exact = StagedLoading(design, case, friction, options.statics)
        for found in refine_path(exact, best, goal, limits):
            again = _replay(exact, found, case, goal, options)
            shape, path, left = again if again[2] < left else (shape, path, left)
            if left <= options.tolerance:
                break
    return shape, path


def _replay(
    loading: StagedLoading, found: Found, case: LoadCase, goal: Goal, options: InverseOptions
) -> tuple[Shape, LoadingPath, float]:
    """The loading as a path, the equilibrium to which `load_along` leads it, and the norm of its residual [m]."""
    path = loading.build_path(found.values, found.cables, found.pull)
    shape = load_along(
        loading.design, path, theta_0=case.theta_0, roll=case.roll, loads=case.loads, friction=loading.friction,
        options=options.statics,
    )  # fmt: skip
    residual = goal.residual(shape.points[-1], section_axes(shape.points)[-1])
    return shape, path, float(np.linalg.norm(residual))


def _stack(parts: Sequence[Any], batch: tuple[int, ...]) -> Any:
    """Shapes or paths of single targets, or parts of them, with the batch's axes."""
    own = {}
    for name, value in vars(parts[0]).items():
        each = [getattr(part, name) for part in parts]
        own[name] = _stack(each, batch) if is_dataclass(value) else np.stack(each).reshape((*batch, *np.shape(each[0])))
    return type(parts[0])(**own)
