"""Start table of the inverse with friction: loadings on a grid of tension and pulls, for every order of cables."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.model.inverse.staged_loading import StagedLoading, State, assign_turns, join_rows, select_rows
from spiraltrunk.model.inverse.start_table import LoadCase, least_tension, section_axes
from spiraltrunk.model.statics.equilibrium import StaticsOptions

_GRID = 13
"""Steps of the grid over a cable's stroke."""

_STEPS_MOST = 2 * _GRID
"""Most steps of a cable, which is longer than straight where another one is pulled."""

_HELD = (0.0, 13.0, 60.0, 200.0)
"""Tensions of the cable held by tension, over the least tension that bends the trunk noticeably [-]."""

_ROUGH = 1e-6
"""Largest residual moment of a start [N m]."""

_ROUGH_TENSION = 8.0
"""Largest change of a tension per increment of a start [N]."""


class FrictionStarts(NamedTuple):
    """Loadings of one load case, s of them."""

    cables: np.ndarray
    """Cable of each turn, shape (s, 3) [-]."""
    values: np.ndarray
    """Tension and pulls beyond taut, shape (s, 3) [N], [m], [m]."""
    tip: np.ndarray
    """Position of the tip, shape (s, 3) [m]."""
    heading: np.ndarray
    """Axis of the last section, shape (s, 3) [-]."""
    base: np.ndarray
    """Orientation of the base for which they were solved, shape (3, 3) [-]."""


@lru_cache(maxsize=32)
def get_friction_starts(
    design: TrunkDesign, case: LoadCase, friction: float, options: StaticsOptions
) -> FrictionStarts:
    """Loadings on a grid, computed once per load case and friction."""
    step = design.cable_stroke / _GRID
    rough = replace(options, increment=step, tension_increment=_ROUGH_TENSION, tolerance=_ROUGH)
    loading = StagedLoading(design, case, friction, rough)
    found = []
    for turns in assign_turns(design.n_cable):
        for values, state in _sweep(loading, turns, step):
            points = state.shape.points
            cables = np.broadcast_to(np.array(turns), values.shape)
            found.append((cables, values, points[:, -1], section_axes(points)[:, -1]))
    cables, values, tip, heading = (np.concatenate(parts) for parts in zip(*found, strict=True))
    return FrictionStarts(cables, values, tip, heading, loading.base[0])


def _sweep(loading: StagedLoading, cables: tuple[int, int, int], step: float) -> list[tuple[np.ndarray, State]]:
    """Values and states: each turn's cable pulled step by step from all states of the turns before."""
    design, is_held = loading.design, cables[0] >= 0
    held = np.array(_HELD) * least_tension(design) if is_held else np.zeros(1)
    held = held[held < 0.5 * design.cable.tension_max]
    values = np.zeros((held.size, 3))
    values[:, 0] = held
    state = loading.load(0, values, cables, select_rows(loading.rest, np.zeros(held.size, np.int64)))
    found = [_keep(state.is_sound, values, state)]
    for turn in (1, 2):
        values, state = np.concatenate([part[0] for part in found]), join_rows([part[1] for part in found])
        for _ in range(_STEPS_MOST if cables[turn] >= 0 else 0):
            values, state = _pull_on(loading, turn, values, state, cables=cables, step=step)
            if len(values) == 0:
                break
            found.append((values, state))
    return found


def _pull_on(
    loading: StagedLoading, turn: int, values: np.ndarray, state: State, *, cables: tuple[int, int, int], step: float
) -> tuple[np.ndarray, State]:
    """Values and states after one more step of the cable whose turn it is, of those that it moves."""
    more, after = values.copy(), values.copy()
    more[:, turn] = step
    after[:, turn] += step
    before = state.shape.cable_change[:, cables[turn]]
    state = loading.load(turn, more, cables, state)
    has_moved = state.shape.cable_change[:, cables[turn]] > before + 0.5 * step
    return _keep(state.is_sound & has_moved, after, state)


def _keep(is_good: np.ndarray, values: np.ndarray, state: State) -> tuple[np.ndarray, State]:
    rows = np.flatnonzero(is_good)
    return values[rows], select_rows(state, rows)
