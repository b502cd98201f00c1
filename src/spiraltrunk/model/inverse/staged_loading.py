"""Forward model with friction: one cable held by tension, then two pulled to lengths one after the other.

Three numbers describe such a loading: the tension T of the cable held by tension, and the lengths u_1 and u_2 by which
the two others are pulled in beyond taut,

    tip = f(T, u_1, u_2),   T, u_1, u_2 >= 0,

for every assignment of cables to the three turns. With T = 0 the tip lies on a surface, which T takes it off. Three
cables held by length are not used: their tensions are ill-conditioned, and reach the largest one within less than a
millimetre of pull.
"""

from __future__ import annotations

from dataclasses import is_dataclass
from itertools import permutations
from typing import Any, NamedTuple, final

import numpy as np

from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.model.inverse.start_table import LoadCase
from spiraltrunk.model.kinematics.cables import PULL_MARGIN
from spiraltrunk.model.kinematics.frames import base_orientation
from spiraltrunk.model.kinematics.shape import Shape, Status, build
from spiraltrunk.model.statics import equilibrium
from spiraltrunk.model.statics.equilibrium import StaticsOptions
from spiraltrunk.model.statics.loading_path import LoadingPath
from spiraltrunk.model.statics.loads import CableInput, read_cables, read_forces

TURNS = 3
"""Turns of a loading: by tension, by length, by length."""


class State(NamedTuple):
    """Equilibria after a turn, a batch of them."""

    shape: Shape
    """Shapes, (b, ...)."""
    pull: np.ndarray
    """What the winders of the cables held by length hold, shape (b, n_cable) [m]."""

    @property
    def is_sound(self) -> np.ndarray:
        """Whether each converged with no winder stalled and no cable left over, shape (b,) [bool]."""
        return np.asarray(self.shape.status == Status.CONVERGED)


def select_rows(state: State, rows: np.ndarray) -> State:
    """The states of these rows, which may repeat, shape (m,)."""
    return State(_select(state.shape, rows), state.pull[rows])


def _select(part: Any, rows: np.ndarray) -> Any:
    """Rows of every array of a shape, or of a part of one."""
    own = {name: _select(value, rows) if is_dataclass(value) else value[rows] for name, value in vars(part).items()}
    return build(type(part), own)


def join_rows(states: list[State]) -> State:
    """All states in one batch."""
    return State(_join([state.shape for state in states]), np.concatenate([state.pull for state in states]))


def _join(parts: list[Any]) -> Any:
    """Every array of shapes, or of parts of them, one after another."""
    own = {}
    for name, value in vars(parts[0]).items():
        each = [getattr(part, name) for part in parts]
        own[name] = _join(each) if is_dataclass(value) else np.concatenate(each)
    return build(type(parts[0]), own)


def assign_turns(n_cable: int) -> list[tuple[int, int, int]]:
    """Every assignment of cables to the turns by tension, by length and by length; -1 for none."""
    if n_cable >= TURNS:
        return [(held, first, second) for held, first, second in permutations(range(n_cable), TURNS)]
    return [(-1, 0, -1)] if n_cable == 1 else [(-1, first, second) for first, second in permutations(range(n_cable), 2)]


@final
class StagedLoading:
    """Loading of one trunk on one base under one load."""

    def __init__(self, design: TrunkDesign, case: LoadCase, friction: float, options: StaticsOptions) -> None:
        self.design, self.friction, self.options = design, friction, options
        self.base = base_orientation(np.full(1, case.theta_0), np.full(1, case.roll))
        self.forces, slack = read_forces(design, case.loads), read_cables(design, None, None, None)
        rest = equilibrium.solve_in_increments(
            design, slack, self.forces, self.base, None, friction=0.0, options=options
        )
        self.rest = State(rest, np.zeros((1, design.n_cable)))

    def load(self, turn: int, values: np.ndarray, cables: tuple[int, int, int], start: State) -> State:
        """Load the cable of one turn.

        Args:
            turn: 0, 1 or 2.
            values: tension and pulls beyond taut, shape (b, 3) [N], [m], [m].
            cables: cable of each turn, -1 for none.
            start: equilibria after the turn before.
        """
        cable, count = cables[turn], self.design.n_cable
        if cable < 0:
            return start
        pull, is_held = start.pull.copy(), np.full(count, True)
        if turn > 0:
            most = PULL_MARGIN * self.design.cable_stroke
            pull[:, cable] = np.minimum(start.shape.cable_change[:, cable] + values[:, turn], most)
        is_held[[c for c in cables[1 : turn + 1] if c >= 0]] = False
        tension = np.where(is_held, 0.0, np.full((len(values), count), self.design.cable.tension_max))
        if cables[0] >= 0:
            tension[:, cables[0]] = values[:, 0]
        inputs = CableInput(pull=pull, tension=tension, by_tension=is_held)
        shape = equilibrium.solve_in_increments(
            self.design, inputs, self.forces, self.base, start.shape, friction=self.friction, options=self.options
        )
        return State(shape, pull)

    def build_path(self, values: np.ndarray, cables: tuple[int, int, int], pull: np.ndarray) -> LoadingPath:
        """The loading of one target as a path; cables whose value is 0 have no turn."""
        count = self.design.n_cable
        used = [(turn, cable) for turn, cable in enumerate(cables) if cable >= 0 and values[turn] > 0]
        order, is_held = np.full(count, -1), np.full(count, True)
        order[: len(used)] = [cable for _, cable in used]
        is_held[[cable for turn, cable in used if turn > 0]] = False
        tension = np.where(is_held, 0.0, self.design.cable.tension_max)
        if used and used[0][0] == 0:
            tension[cables[0]] = values[0]
        return LoadingPath(order=order, pull=np.where(is_held, 0.0, pull), tension=tension, by_tension=is_held)
