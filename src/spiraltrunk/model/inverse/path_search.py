"""Search with friction: Levenberg-Marquardt over a loading's tension and pulls, from several starts and orders.

The Jacobian is taken by finite differences and kept up to date by Broyden's rank-one formula,

    J <- J + (dr - J dx) dx^T / |dx|^2,

until a step gains too little (C. G. Broyden, Math. Comp. 19, 1965, 577-593).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple, final

import numpy as np

from spiraltrunk.model.inverse.friction_starts import FrictionStarts
from spiraltrunk.model.inverse.staged_loading import TURNS, StagedLoading, State
from spiraltrunk.model.inverse.start_table import least_tension, section_axes

_DIFFERENCE = 1e-4
"""Step of the finite differences, in the scaled unknowns [-]."""

_LONGEST = 1.5
"""Largest change of a scaled unknown in one step [-]."""

_GOOD = 0.3
"""Part of the residual left by a step up to which Broyden's Jacobian is kept [-]."""

_LEAST_GAIN = 1e-4
"""Predicted relative gain below which a search has ended [-]."""

_SLOW = 0.7
"""Part of the residual left by a step above which it counts as slow [-]."""

_SLOW_MOST = 6
"""Slow or failed steps in a row with which a search has ended [-]."""

_DAMPING_MOST = 1e3
"""Damping at which a search has ended [-]."""

_REPEATED = 1.3
"""Factor on the distance of starts of an order that was tried already [-]."""

_LESS = (0.97, 0.93, 0.85)
"""Parts of a start's pulls that are tried where the start itself is not sound [-]."""

_VANISHING = 1e-3
"""Scaled unknown below which a tension or a pull is set to 0 where the loading is ill-conditioned [-]."""

_FROM_STARTS = 0.75
"""Part of the tries that begin at the table's starts; the others begin beside the best loading found [-]."""

_SHIFTS = np.array([[0.5, 0.0, 0.0], [0.0, 0.7, -0.7], [0.0, -0.7, 0.7], [-0.5, 0.3, 0.3]])
"""Where beside it, in the scaled unknowns [-]."""

_HELD_UNIT = 26.0
"""Tension at which its scale turns from linear to logarithmic, over the least tension that bends the trunk [-]."""

_PULL_PARTS = 13.0
"""Pulls are scaled by the stroke over this [-]."""


class Goal(NamedTuple):
    """What one target asks for."""

    tip: np.ndarray
    """Position of the tip, shape (3,) [m]."""
    heading: np.ndarray
    """Unit vector of the last section's direction, shape (3,) [-]."""
    weight: float
    """Weight of the direction; 0 leaves it out [m]."""

    def residual(self, tip: np.ndarray, heading: np.ndarray) -> np.ndarray:
        """Distance of the tip and weighted difference of the direction, shape (..., 3 or 6) [m]."""
        if self.weight == 0.0:
            return tip - self.tip
        return np.concatenate([tip - self.tip, self.weight * (heading - self.heading)], axis=-1)


class Found(NamedTuple):
    """Best loading of a search."""

    values: np.ndarray
    """Tension and pulls beyond taut, shape (3,) [N], [m], [m]."""
    cables: tuple[int, int, int]
    """Cable of each turn."""
    pull: np.ndarray
    """Pulls of the cables held by length, shape (n_cable,) [m]."""
    norm: float
    """Norm of the residual [m]."""


def search_path(loading: StagedLoading, starts: FrictionStarts, goal: Goal, limits: tuple[int, int, float]) -> Found:
    """Best loading for one target; ``limits``: most starts, most loadings from one, norm that is enough [m]."""
    tries, rounds, enough = limits
    turned = loading.base[0] @ starts.base.T
    misses = goal.residual(starts.tip @ turned.T, starts.heading @ turned.T)
    score = np.linalg.norm(misses, axis=1) * (1 + 0.3 * starts.values[:, 0] / loading.design.cable.tension_max)
    best: Found | None = None
    for attempt in range(min(tries, score.size)):
        shift = np.zeros(TURNS)
        if best is not None and attempt >= _FROM_STARTS * tries:
            cables, values, shift = best.cables, best.values, _SHIFTS[attempt % len(_SHIFTS)]
        else:
            cables, values = _take_next(starts, score)
        found = _Search(loading, cables, goal).run(values, shift, rounds, enough)
        best = found if best is None or found.norm < best.norm else best
        if best.norm <= enough:
            break
    assert best is not None  # There is at least one start: rest.
    return best


def refine_path(loading: StagedLoading, found: Found, goal: Goal, limits: tuple[int, int, float]) -> Iterator[Found]:
    """Searches from a loading that ``loading``, solved more exactly, does not confirm; ``limits`` as `search_path`.

    In the first, tensions and pulls next to 0 are held at 0: under some micronewtons of tension the equilibrium of a
    taut cable can be ill-conditioned, and a smaller residual moment then ends at another one, millimetres away. The
    second leaves all unknowns free.
    """
    _, rounds, enough = limits
    for least in (_VANISHING, 0.0):
        search = _Search(loading, found.cables, goal)
        search.most = np.where(search.scale(found.values) < least, 0.0, search.most)
        yield search.run(found.values, np.zeros(TURNS), rounds, enough)


def _take_next(starts: FrictionStarts, score: np.ndarray) -> tuple[tuple[int, int, int], np.ndarray]:
    """Cables and values of the best start, which is then not taken again, and its order later."""
    index = int(np.argmin(score))
    held, first, second = starts.cables[index].tolist()
    score[index] = math.inf
    score[(starts.cables == starts.cables[index]).all(axis=1)] *= _REPEATED
    return (held, first, second), starts.values[index]


class _Trial(NamedTuple):
    """One loading on trial."""

    x: np.ndarray
    states: list[State]
    residual: np.ndarray
    norm: float


@final
class _Search:
    """Levenberg-Marquardt from one start, for one assignment of cables to turns."""

    def __init__(self, loading: StagedLoading, cables: tuple[int, int, int], goal: Goal) -> None:
        self.loading, self.cables, self.goal, self.count = loading, cables, goal, 0
        design = loading.design
        self.unit = np.array([_HELD_UNIT * least_tension(design), *2 * [design.cable_stroke / _PULL_PARTS]])
        most = self.scale(np.array([design.cable.tension_max, *2 * [2 * design.cable_stroke]]))
        self.most = np.where(np.array(cables) >= 0, most, 0.0)

    def scale(self, values: np.ndarray) -> np.ndarray:
        """Scaled unknowns x: log(1 + T / T_unit), u_1 / u_unit, u_2 / u_unit, shape (3,) [-]."""
        x = np.asarray(values / self.unit)
        return np.array([math.log1p(x[0]), x[1], x[2]])

    def unscale(self, x: np.ndarray) -> np.ndarray:
        """Tension and pulls of scaled unknowns, shape (3,) [N], [m], [m]."""
        held = min(self.unit[0] * math.expm1(x[0]), self.loading.design.cable.tension_max)
        return np.array([held, *(x[1:] * self.unit[1:])])

    def load(self, x: np.ndarray, states: list[State]) -> _Trial:
        """Loading at ``x``, of which ``states`` are known: rest and those after the first turns; norm inf where bad."""
        states, values = list(states), self.unscale(x)
        self.count += 1
        for turn in range(len(states) - 1, TURNS):
            is_used = values[turn] > 0
            states.append(self.loading.load(turn, values[None], self.cables, states[-1]) if is_used else states[-1])
            if not states[-1].is_sound[0]:
                return _Trial(x, states, np.full(6 if self.goal.weight else 3, math.inf), math.inf)
        points = states[-1].shape.points[0]
        residual = self.goal.residual(points[-1], section_axes(points)[-1])
        return _Trial(x, states, residual, float(np.linalg.norm(residual)))

    def differentiate(self, trial: _Trial) -> np.ndarray:
        """Jacobian of the residual by finite differences; turns before the changed one are not loaded again."""
        columns = np.zeros((trial.residual.size, TURNS))
        for turn in range(TURNS):
            if self.cables[turn] < 0:
                continue
            x = trial.x.copy()
            x[turn] += _DIFFERENCE if x[turn] + _DIFFERENCE <= self.most[turn] else -_DIFFERENCE
            other = self.load(x, trial.states[: turn + 1])
            if math.isfinite(other.norm):
                columns[:, turn] = (other.residual - trial.residual) / (x[turn] - trial.x[turn])
        return columns

    def begin(self, x: np.ndarray) -> _Trial:
        """Loading at ``x``, or with less pull where the table's coarser loading held and this one does not."""
        trial = self.load(x, [self.loading.rest])
        for share in _LESS:
            if math.isfinite(trial.norm):
                break
            trial = self.load(x * np.array([1.0, share, share]), [self.loading.rest])
        return trial

    def run(self, start: np.ndarray, shift: np.ndarray, rounds: int, enough: float) -> Found:
        """Search from tension and pulls ``start``, shifted, until the norm is ``enough`` or nothing is gained."""
        best = self.begin(np.clip(self.scale(start) + shift, 0.0, self.most))
        damping, jacobian, slow = 1e-6, None, 0
        while 0.5 * enough < best.norm < math.inf and self.count < rounds and slow < _SLOW_MOST:
            is_fresh = jacobian is None
            jacobian = self.differentiate(best) if jacobian is None else jacobian
            x = best.x + bounded_step(best.x, self.most, jacobian, best.residual, damping)
            step = x - best.x
            expected = float(np.linalg.norm(best.residual + jacobian @ step))
            if expected > (1 - _LEAST_GAIN) * best.norm or damping > _DAMPING_MOST:
                if is_fresh:
                    break
                jacobian = None
                continue
            trial = self.load(x, [self.loading.rest])
            slow = slow + 1 if trial.norm > _SLOW * best.norm else 0
            is_poor = not trial.norm <= _GOOD * best.norm
            if math.isfinite(trial.norm):
                change = trial.residual - best.residual - jacobian @ step
                jacobian = jacobian + np.outer(change, step) / (step @ step)
            if trial.norm < best.norm:
                damping = 3 * damping if is_fresh and trial.norm > 0.8 * best.norm else max(damping / 10, 1e-9)
                best, jacobian = trial, None if is_poor else jacobian
            else:
                damping = max(30 * damping, 1e-2) if is_fresh else max(3 * damping, 1e-3)
                jacobian = jacobian if is_fresh else None
        return Found(self.unscale(best.x), self.cables, best.states[-1].pull[0], best.norm)


def bounded_step(
    x: np.ndarray, most: np.ndarray, jacobian: np.ndarray, residual: np.ndarray, damping: float
) -> np.ndarray:
    """Damped Gauss-Newton step that keeps 0 <= x <= most; unknowns that meet a bound are held there.

    (J^T J + damping D) dx = -J^T r in the free unknowns, with J the Jacobian, r the residual and D = diag(J^T J).
    """
    matrix, gradient, step = jacobian.T @ jacobian, jacobian.T @ residual, np.zeros(x.size)
    weight = damping * (np.diag(matrix) + 1e-3 * np.trace(matrix) + 1e-30)
    is_held = ((x <= 0) & (gradient > 0)) | ((x >= most) & (gradient < 0)) | (most == 0)
    for _ in range(x.size):
        free = np.flatnonzero(~is_held)
        if free.size == 0:
            break
        right = -(gradient[free] + matrix[np.ix_(free, np.flatnonzero(is_held))] @ step[is_held])
        wish = np.linalg.solve(matrix[np.ix_(free, free)] + np.diag(weight[free]), right)
        allowed = np.clip(wish, -x[free], most[free] - x[free])
        step[free] = allowed
        if (allowed == wish).all():
            break
        is_held[free[allowed != wish]] = True
    return step * min(1.0, _LONGEST / max(float(np.abs(step).max()), 1e-300))
