"""Searches for tensions from several starts, each answer checked by solving its equilibrium from the straight trunk."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import final

import numpy as np

from spiraltrunk.design.checks import check_count, check_number
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import ModelError
from spiraltrunk.model import statics
from spiraltrunk.model.compiled import share
from spiraltrunk.model.inverse_starts import Stand, Starts, get_starts
from spiraltrunk.model.kernels.aim import Aim
from spiraltrunk.model.kernels.balance import Trunk
from spiraltrunk.model.kernels.batch import Problem, Solution
from spiraltrunk.model.kernels.inverse import Found, rank, search_rows
from spiraltrunk.model.loading import Fields, Loads, base_orientation, read_fields, read_numbers
from spiraltrunk.model.shape import Shape
from spiraltrunk.model.statics import StaticsOptions

_CHUNK = 8
"""Targets that a core searches in a row; between two such rows a batch can be stopped."""

_CLOSE = 0.02
"""Part of the trunk's length beyond which a start's tension ranks it no further behind [-]."""

_STEP = math.radians(15.0)
"""Tilts for which starts are solved lie this apart [rad], rolls twice this, loads 50 g and 0.5 N: on a moving base they
would be solved anew every time."""

_APART = 0.08
"""Part of the trunk's length by which the tips of every other start lie apart [-]."""


@final
@dataclass(frozen=True, kw_only=True)
class InverseOptions:
    """How the search is done; the defaults are for use."""

    tolerance: float = 5e-5
    """Distance within which a target counts as reached [m]."""
    tries: int = 16
    """Starts from which it is sought at most."""
    samples: int = 400
    """Equilibria solved once for a trunk, its stand and its load, from which the nearest are taken as starts."""
    rounds: int = 60
    """Equilibria solved from one start at most."""
    statics: StaticsOptions = field(default_factory=StaticsOptions)
    """How the trunk is modelled."""

    def __post_init__(self) -> None:
        check_number("tolerance", self.tolerance, least=1e-7, below=1.0)
        check_count("tries", self.tries, least=1, most=1000)
        check_count("samples", self.samples, least=1, most=10**5)
        check_count("rounds", self.rounds, least=1, most=10**4)


@final
@dataclass(frozen=True, kw_only=True)
class Scene:
    """A trunk as it stands and is loaded, one row a target."""

    theta_0: np.ndarray
    """Angle of the base axis below the horizontal, shape (b,) [rad]."""
    roll: np.ndarray
    """Turn about the base axis, shape (b,) [rad]."""
    loads: Loads
    """Masses of shape (b,) [kg], forces of shape (b, 3) [N]."""


def read_scene(
    theta_0: np.ndarray, roll: np.ndarray, loads: Loads, batch: tuple[int, ...]
) -> tuple[Scene, tuple[int, ...]]:
    """Stand and loads with one row a target, and the batch that they make with the targets'.

    Raises:
        ModelError: where they do not broadcast.
    """
    mass = read_numbers("loads.mass", loads.mass)
    force = None if loads.force is None else read_numbers("loads.force", loads.force)
    if force is not None and force.shape[-1:] != (3,):
        raise ModelError(f"loads.force has shape {force.shape}; allowed: (..., 3)")
    shapes = [batch, theta_0.shape, roll.shape, mass.shape, () if force is None else force.shape[:-1]]
    try:
        batch = np.broadcast_shapes(*shapes) if any(shapes) else ()
    except ValueError:
        raise ModelError(
            f"targets, theta_0, roll and loads have batches {shapes}; allowed: ones that broadcast"
        ) from None
    spread = Loads(
        mass=_spread(mass, batch), section=loads.section, force_section=loads.force_section,
        force=None if force is None else np.broadcast_to(force, (*batch, 3)).reshape(-1, 3),
    )  # fmt: skip
    return Scene(theta_0=_spread(theta_0, batch), roll=_spread(roll, batch), loads=spread), batch


def _spread(array: np.ndarray, batch: tuple[int, ...]) -> np.ndarray:
    """One number a row."""
    return np.broadcast_to(array, batch).ravel() if batch else array.reshape(1)


def find(design: TrunkDesign, scene: Scene, aim: Aim, options: InverseOptions, batch: tuple[int, ...]) -> Shape:
    """The equilibrium nearest to each target, as solved from the straight trunk at the tensions found.

    Returns:
        Shapes with the batch's axes.
    """
    rows, search = len(scene.theta_0), _Search.of(design, scene, aim, options)
    ranked = _rank(design, scene, aim, options)
    best, norm = np.zeros((rows, design.n_cable)), np.full(rows, np.inf)
    todo, found = np.arange(rows), search.found
    for attempt in range(min(options.tries, options.samples)):
        for b in todo:
            start = ranked[b].pick(attempt, _APART * design.length)
            found.tension[b], found.bend[b] = ranked[b].starts.tension[start], ranked[b].starts.bend[start]
        search.run(todo, options.rounds)
        nearer = todo[found.norm[todo] < norm[todo]]
        norm[nearer], best[nearer] = found.norm[nearer], found.tension[nearer]
        todo = todo[norm[todo] > options.tolerance]
        if not todo.size:
            break
    lost = todo[found.norm[todo] != norm[todo]]
    if lost.size:  # The last attempt was not the best one.
        found.tension[lost] = best[lost]
        search.run(lost, 0)
    return statics.read_out(search.solution, batch)


@final
@dataclass(frozen=True, kw_only=True)
class _Search:
    """All that the kernel reads and fills, one row a target."""

    trunk: Trunk
    nd: int
    problem: Problem
    aim: Aim
    found: Found
    solution: Solution
    tolerance: float

    @classmethod
    def of(cls, design: TrunkDesign, scene: Scene, aim: Aim, options: InverseOptions) -> _Search:
        rows = len(scene.theta_0)
        trunk, straight = statics.get_trunk(design, options.statics)
        base, weights = _read_stands(design, scene)
        return cls(
            trunk=trunk, nd=3 if options.statics.has_torsion else 2, aim=aim,
            problem=statics.pose_tensions(straight, base, weights, design.cable.tension_max, options.statics),
            found=Found(np.zeros((rows, design.n_cable)), np.zeros((rows, design.n_joint, 3)), np.zeros(rows)),
            solution=statics.make_room(trunk, rows), tolerance=options.tolerance,
        )  # fmt: skip

    def run(self, rows: np.ndarray, rounds: int) -> None:
        """Search some rows, on all cores where there are enough, and in chunks so that Ctrl-C is heard."""

        def search(first: int, last: int) -> None:
            search_rows(
                rows[first:last], rounds, self.tolerance, self.nd, self.trunk, self.problem, self.aim, self.found,
                self.solution,
            )  # fmt: skip

        share(search, rows.size, _CHUNK)


@final
@dataclass(kw_only=True)
class _Ranked:
    """Known equilibria of a target's stand, and how far each is from the target."""

    starts: Starts
    score: np.ndarray
    order: np.ndarray | None = None

    def pick(self, attempt: int, apart: float) -> int:
        """Start of an attempt: the nearest, then in turns the next one, and the next far from those before."""
        if attempt == 0:
            return int(self.score.argmin())
        if self.order is None:
            self.order = np.argsort(self.score, kind="stable")
        return _pick(self.starts, self.order, attempt, apart)


def _pick(starts: Starts, order: np.ndarray, attempt: int, apart: float) -> int:
    """Start of an attempt: in turns the next in the order, and the next whose tip is ``apart`` from those before."""
    if attempt % 2 == 0:
        return int(order[attempt // 2])
    tips = starts.points[order, -1]
    chosen, is_free = 0, np.full(len(order), True)
    for _ in range(attempt // 2 + 1):
        is_free &= np.linalg.norm(tips - tips[chosen], axis=-1) > apart
        if not is_free.any():
            return int(order[attempt % len(order)])
        chosen = int(is_free.argmax())
    return int(order[chosen])


def _read_stands(design: TrunkDesign, scene: Scene) -> tuple[np.ndarray, Fields]:
    """Base and weights of every row in the arrays that the kernels read."""
    if len(scene.theta_0) == 1:
        one = _stand(scene, 0)
        base, weights = base_orientation(one.theta_0, one.roll)[None], read_fields(design, one.loads)
        return base, Fields(
            direction=weights.direction.copy()[None], factor=weights.factor.copy()[None],
            moment=weights.moment.copy()[None],
        )  # fmt: skip
    weights = read_fields(design, scene.loads)
    return np.array(base_orientation(scene.theta_0, scene.roll), order="C"), Fields(
        direction=np.array(weights.direction, order="C"), factor=np.array(weights.factor, order="C"),
        moment=np.array(weights.moment, order="C"),
    )  # fmt: skip


def _rank(design: TrunkDesign, scene: Scene, aim: Aim, options: InverseOptions) -> list[_Ranked]:
    """Known equilibria of every row, and how far they are."""
    groups: dict[Stand, list[int]] = {}
    for b in range(len(scene.theta_0)):
        groups.setdefault(_stand(scene, b), []).append(b)
    ranked: dict[int, _Ranked] = {}
    for stand, rows in groups.items():
        starts, turn = _known(design, stand, options)
        score = np.empty((len(rows), options.samples))
        rank(np.array(rows), aim, (starts.points, starts.heads), turn, score)
        score += np.minimum(score, _CLOSE * design.length) * starts.effort
        ranked.update((b, _Ranked(starts=starts, score=own)) for b, own in zip(rows, score, strict=True))
    return [ranked[b] for b in range(len(scene.theta_0))]


def _known(design: TrunkDesign, stand: Stand, options: InverseOptions) -> tuple[Starts, np.ndarray]:
    """Equilibria solved for a stand and loads near these, and the turn that brings them to this stand."""
    near = replace(
        stand, theta_0=_STEP * round(stand.theta_0 / _STEP), roll=2 * _STEP * round(stand.roll / (2 * _STEP)),
        mass=round(20 * stand.mass) / 20,
        force=None if stand.force is None else tuple(round(2 * part) / 2 for part in stand.force),
    )  # fmt: skip
    base, other = base_orientation(stand.theta_0, stand.roll), base_orientation(near.theta_0, near.roll)
    return get_starts(design, near, options.samples, options.statics), base @ other.T


def _stand(scene: Scene, b: int) -> Stand:
    force, loads = scene.loads.force, scene.loads
    return Stand(
        float(scene.theta_0[b]), float(scene.roll[b]), float(np.asarray(loads.mass)[b]), loads.section,
        None if force is None else tuple(map(float, np.asarray(force)[b])), loads.force_section,
    )  # fmt: skip
