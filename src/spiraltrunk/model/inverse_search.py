"""Searches for tensions from several starts, each answer checked by solving its equilibrium from the straight trunk."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, fields, replace
from typing import Any, final

import numpy as np

from spiraltrunk.design.checks import check_count, check_number
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import ModelError
from spiraltrunk.model import statics
from spiraltrunk.model.compiled import share
from spiraltrunk.model.inverse_starts import Stand, Starts, compute_starts, section_axes
from spiraltrunk.model.kernels.aim import Aim, miss_rows
from spiraltrunk.model.kernels.inverse import Found, Poses, rank, search_rows
from spiraltrunk.model.loading import Loads, base_orientation, read_fields, read_numbers
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

    def take(self, rows: np.ndarray) -> Scene:
        """Some of the rows."""
        mass, force = np.asarray(self.loads.mass)[rows], self.loads.force
        loads = Loads(
            mass=mass, section=self.loads.section, force_section=self.loads.force_section,
            force=None if force is None else np.asarray(force)[rows],
        )  # fmt: skip
        return Scene(theta_0=self.theta_0[rows], roll=self.roll[rows], loads=loads)


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
        batch = np.broadcast_shapes(*shapes)
    except ValueError:
        raise ModelError(
            f"targets, theta_0, roll and loads have batches {shapes}; allowed: ones that broadcast"
        ) from None
    spread = Loads(
        mass=np.broadcast_to(mass, batch).ravel(), section=loads.section, force_section=loads.force_section,
        force=None if force is None else np.broadcast_to(force, (*batch, 3)).reshape(-1, 3),
    )  # fmt: skip
    scene = Scene(
        theta_0=np.broadcast_to(theta_0, batch).ravel(), roll=np.broadcast_to(roll, batch).ravel(), loads=spread
    )
    return scene, batch


def find(design: TrunkDesign, scene: Scene, aim: Aim, options: InverseOptions) -> Shape:
    """The equilibrium nearest to each target, as solved from the straight trunk at the tensions found.

    Returns:
        Shapes with one row a target.
    """
    rows, most = len(scene.theta_0), options.tries
    found = _make_room(design, rows)
    ranked = _rank(design, scene, aim, options)
    poses = _read_poses(design, scene)
    best, norm, shape = np.zeros((rows, design.n_cable)), np.full(rows, np.inf), None
    todo = np.arange(rows)
    for attempt in range(min(most, options.samples)):
        for b in todo:
            starts, order = ranked[b]
            start = _pick(starts, order, attempt, _APART * design.length)
            found.tension[b], found.bend[b] = starts.tension[start], starts.bend[start]
        _search(design, todo, (poses, aim, found), options)
        shape = _solve(design, scene.take(todo), found.tension[todo], options)
        now = _miss(take(aim, todo), shape)
        is_nearer = now < norm[todo]
        norm[todo[is_nearer]], best[todo[is_nearer]] = now[is_nearer], found.tension[todo[is_nearer]]
        todo = todo[norm[todo] > options.tolerance]
        if not todo.size:
            break
    return shape if shape is not None and attempt == 0 else _solve(design, scene, best, options)


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


def take(aim: Aim, rows: np.ndarray) -> Aim:
    """Some of the targets."""
    return aim._replace(point=aim.point[rows], heading=aim.heading[rows], circle=aim.circle[rows])


def _make_room(design: TrunkDesign, rows: int) -> Found:
    return Found(np.zeros((rows, design.n_cable)), np.zeros((rows, design.n_joint, 3)), np.zeros((rows, 2)))


def _read_poses(design: TrunkDesign, scene: Scene) -> Poses:
    """Base and weights of every row in the arrays that the kernels read."""
    weights = read_fields(design, scene.loads)
    most = np.full(design.n_cable, design.cable.tension_max)
    return Poses(
        np.array(base_orientation(scene.theta_0, scene.roll), order="C"), np.array(weights.direction, order="C"),
        np.array(weights.factor, order="C"), np.array(weights.moment, order="C"), most,
    )  # fmt: skip


def _rank(design: TrunkDesign, scene: Scene, aim: Aim, options: InverseOptions) -> list[tuple[Starts, np.ndarray]]:
    """Known equilibria of every row, and their order, nearest first."""
    stands = [_stand(scene, b) for b in range(len(scene.theta_0))]
    ranked: list[tuple[Starts, np.ndarray] | None] = [None] * len(stands)
    for stand in dict.fromkeys(stands):
        rows = np.array([b for b, other in enumerate(stands) if other == stand])
        starts, turn = _known(design, stand, options)
        score = np.empty((len(rows), options.samples))
        rank(take(aim, rows), starts.points @ turn.T, starts.heads @ turn.T, score)
        score += np.minimum(score, _CLOSE * design.length) * starts.effort
        for b, order in zip(rows, np.argsort(score, axis=1, kind="stable"), strict=True):
            ranked[b] = (starts, order)
    return [entry for entry in ranked if entry is not None]


def _known(design: TrunkDesign, stand: Stand, options: InverseOptions) -> tuple[Starts, np.ndarray]:
    """Equilibria solved for a stand and loads near these, and the turn that brings them to this stand."""
    near = replace(
        stand, theta_0=_STEP * round(stand.theta_0 / _STEP), roll=2 * _STEP * round(stand.roll / (2 * _STEP)),
        mass=round(20 * stand.mass) / 20,
        force=None if stand.force is None else tuple(round(2 * part) / 2 for part in stand.force),
    )  # fmt: skip
    base, other = base_orientation(stand.theta_0, stand.roll), base_orientation(near.theta_0, near.roll)
    return compute_starts(design, near, options.samples, options.statics), base @ other.T


def _stand(scene: Scene, b: int) -> Stand:
    force, loads = scene.loads.force, scene.loads
    return Stand(
        float(scene.theta_0[b]), float(scene.roll[b]), float(np.asarray(loads.mass)[b]), loads.section,
        None if force is None else tuple(map(float, np.asarray(force)[b])), loads.force_section,
    )  # fmt: skip


def _search(design: TrunkDesign, rows: np.ndarray, work: tuple[Poses, Aim, Found], options: InverseOptions) -> None:
    """Search all rows, on all cores where there are enough, and in chunks so that Ctrl-C is heard."""
    trunk, nd = statics.build_trunk(design, options.statics), 3 if options.statics.has_torsion else 2
    poses, aim, found = work

    def search(first: int, last: int) -> None:
        search_rows(rows[first:last], options.rounds, options.tolerance, nd, trunk, poses, aim, found)

    share(search, rows.size, _CHUNK)


def _solve(design: TrunkDesign, scene: Scene, tension: np.ndarray, options: InverseOptions) -> Shape:
    """Equilibria from the straight trunk; a single one goes the quick way."""
    theta_0, roll, loads = scene.theta_0, scene.roll, scene.loads
    if len(tension) > 1:
        return statics.solve(
            design, tension=tension, theta_0=theta_0, roll=roll, loads=loads, friction=0.0, options=options.statics
        )
    one = _stand(scene, 0)
    shape = statics.solve(
        design, tension=tension[0], theta_0=one.theta_0, roll=one.roll, loads=one.loads, friction=0.0,
        options=options.statics,
    )  # fmt: skip
    return fold(shape, (1,), 0)


def fold(whole: Any, batch: tuple[int, ...], own: int = 1) -> Any:
    """A dataclass of arrays, of which the first ``own`` axes are folded to ``batch``."""
    if isinstance(whole, np.ndarray | np.generic):
        return np.reshape(whole, (*batch, *whole.shape[own:]))
    if whole is None:
        return None
    return type(whole)(**{part.name: fold(getattr(whole, part.name), batch, own) for part in fields(whole)})


def _miss(aim: Aim, shape: Shape) -> np.ndarray:
    norm = np.empty(len(shape.points))
    miss_rows(shape.points, section_axes(shape.points), aim, norm)
    return norm
