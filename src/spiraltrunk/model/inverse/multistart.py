"""Searches for tensions from several starts, each answer being what the straight trunk goes to at its tensions."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any, final

import numpy as np
from numpy.typing import ArrayLike

from spiraltrunk.checks import broadcast_batches, check_count, check_number, check_type, read_numbers
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import ModelError
from spiraltrunk.model.identity_cache import IdentityKey
from spiraltrunk.model.inverse.kernels.multistart import Limits, seek_rows
from spiraltrunk.model.inverse.kernels.target_residual import Aim
from spiraltrunk.model.inverse.start_table import Stand, Starts, get_starts
from spiraltrunk.model.jit import share
from spiraltrunk.model.kinematics.frames import base_orientation
from spiraltrunk.model.kinematics.shape import Shape
from spiraltrunk.model.statics import equilibrium
from spiraltrunk.model.statics.equilibrium import StaticsOptions
from spiraltrunk.model.statics.kernels.batch import Problem
from spiraltrunk.model.statics.kernels.energy import Trunk
from spiraltrunk.model.statics.loads import MOST_TURNED, Fields, Loads, read_angle, read_fields

_CHUNK = 8
"""Targets that a core searches in a row; between two such rows a batch can be stopped."""

_CLOSE = 0.02
"""Part of the trunk's length beyond which a start's tension ranks it no further behind [-]."""

_STEP = math.radians(15.0)
"""Tilts for which starts are solved lie this apart [rad], rolls twice this, loads 50 g and 0.5 N: on a moving base they
would be solved anew every time."""

_APART = 0.08
"""Part of the trunk's length by which the tips of every other start lie apart [-]."""


_NONE = Loads()


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
        check_type("statics", self.statics, StaticsOptions)
        check_number("tolerance", self.tolerance, least=1e-7, below=1.0)
        check_count("tries", self.tries, least=1, most=1000)
        check_count("samples", self.samples, least=1, most=10**5)
        check_count("rounds", self.rounds, least=1, most=10**4)


@final
@dataclass(frozen=True, kw_only=True)
class Scene:
    """A trunk as it stands and is loaded, one row a target."""

    stands: list[Stand]
    """Every row in plain numbers."""
    theta_0: np.ndarray
    """Angle of the base axis below the horizontal, shape (b,) [rad]."""
    roll: np.ndarray
    """Turn about the base axis, shape (b,) [rad]."""
    loads: Loads
    """Masses of shape (b,) [kg], forces of shape (b, 3) [N]."""


def read_scene(
    stand: tuple[ArrayLike, ArrayLike], loads: Loads | None, batch: tuple[int, ...]
) -> tuple[Scene, tuple[int, ...]]:
    """Stand, theta_0 and roll, and loads with one row a target, and the batch that they make with the targets'.

    Raises:
        ModelError: where they are not angles and loads, are none at all, or do not broadcast.
    """
    bare = _read_bare(*stand) if loads is None and not batch else None
    if bare is not None:
        return bare, ()
    theta_0, roll = read_angle("theta_0", stand[0]), read_angle("roll", stand[1])
    loads = _NONE if loads is None else loads
    check_type("loads", loads, Loads)
    mass = read_numbers("loads.mass", loads.mass)
    force = None if loads.force is None else read_numbers("loads.force", loads.force, shape=(..., 3))
    batches = {
        "targets": batch, "theta_0": theta_0.shape, "roll": roll.shape, "loads.mass": mass.shape,
        "loads.force": () if force is None else force.shape[:-1],
    }  # fmt: skip
    batch = broadcast_batches(batches)
    if 0 in batch:
        raise ModelError("targets, theta_0, roll and loads are empty; allowed: at least one of each")
    theta_0, roll, mass = _spread(theta_0, batch), _spread(roll, batch), _spread(mass, batch)
    force = None if force is None else np.broadcast_to(force, (*batch, 3)).reshape(-1, 3)
    at = loads.section, loads.force_section
    forces = [None] * mass.size if force is None else map(tuple, force.tolist())
    stands = [
        Stand(down, turn, weight, at[0], pull, at[1])
        for down, turn, weight, pull in zip(theta_0.tolist(), roll.tolist(), mass.tolist(), forces, strict=True)
    ]
    spread = Loads(mass=mass, section=at[0], force=force, force_section=at[1])
    return Scene(stands=stands, theta_0=theta_0, roll=roll, loads=spread), batch


def _read_bare(theta_0: ArrayLike, roll: ArrayLike) -> Scene | None:
    """The scene of one target without loads, where theta_0 and roll are plain numbers, sooner than through arrays."""
    if not (type(theta_0) is type(roll) is float and abs(theta_0) <= MOST_TURNED and abs(roll) <= MOST_TURNED):
        return None
    stand = Stand(theta_0, roll, 0.0, _NONE.section, None, _NONE.force_section)
    return Scene(stands=[stand], theta_0=np.array((theta_0,)), roll=np.array((roll,)), loads=_NONE)


def _spread(array: np.ndarray, batch: tuple[int, ...]) -> np.ndarray:
    """One number a row."""
    return np.broadcast_to(array, batch).ravel() if batch else array.reshape(1)


def find(design: TrunkDesign, scene: Scene, aim: Aim, options: InverseOptions, batch: tuple[int, ...]) -> Shape:
    """The equilibrium nearest to each target, as solved from the straight trunk at the tensions found.

    Returns:
        Shapes with the batch's axes.
    """
    key, count = IdentityKey(design), len(scene.stands)
    posed, trunk = _keep_posed(key, options) if count == 1 else _pose_tensions(design, count, options)
    base, weights = _read_stands(design, scene)
    problem = Problem(base, weights.direction, weights.factor, weights.moment, *posed)
    solution = equilibrium.make_room(trunk, count)
    for stand, members in _group(scene.stands).items():
        starts, limits = _keep_starts(key, _near(stand), options)
        rows, turn = np.array(members), np.dot(base[members[0]], starts.base.T)
        _seek(rows, limits, (stand.loads is None, trunk, problem, aim, starts.known, turn, solution))
    return equilibrium.read_out(solution, batch)


def _pose_tensions(design: TrunkDesign, rows: int, options: InverseOptions) -> tuple[tuple[np.ndarray, ...], Trunk]:
    """What a `Problem` has after base and weights: no friction, tensions up to the design's largest yet to come."""
    trunk, straight = equilibrium.get_trunk(design, options.statics)
    count, model = design.n_cable, options.statics
    none, friction = np.zeros(count), np.array((0.0, model.hole_stiffness, model.tolerance, model.steps_most))
    return (
        np.zeros((rows, count)), np.zeros((rows, 2, count)), np.ones(rows, np.int64),
        np.full((rows, count), design.cable.tension_max), np.zeros((rows, 2)), np.full(count, True), none, friction,
        straight,
    ), trunk  # fmt: skip


@lru_cache(maxsize=64)
def _keep_posed(key: IdentityKey, options: InverseOptions) -> tuple[tuple[np.ndarray, ...], Trunk]:
    """The same for one target, kept; nothing is written into it."""
    return _pose_tensions(key.design, 1, options)


@lru_cache(maxsize=128)
def _keep_starts(key: IdentityKey, stand: Stand, options: InverseOptions) -> tuple[Starts, Limits]:
    """`get_starts`, and how they are used."""
    starts, length = get_starts(key.design, stand, options.samples, options.statics), key.design.length
    return starts, Limits(
        options.tries, options.rounds, options.tolerance, _APART * length, _CLOSE * length,
        3 if options.statics.has_torsion else 2, starts.slack,
    )  # fmt: skip


def _seek(rows: np.ndarray, limits: Limits, scene: tuple[Any, ...]) -> None:
    """Seek some targets, on all cores where there are enough, and in chunks so that Ctrl-C is heard."""
    share(lambda first, last: seek_rows(rows[first:last], limits, *scene), rows.size, _CHUNK)


def _read_stands(design: TrunkDesign, scene: Scene) -> tuple[np.ndarray, Fields]:
    """Base and weights of every row in the arrays that the kernels read."""
    if len(scene.stands) == 1:
        one = scene.stands[0]
        base, loads = base_orientation(one.theta_0, one.roll)[None], one.loads
        return base, _own_weight(IdentityKey(design)) if loads is None else _read_row(design, loads)
    weights = read_fields(design, scene.loads)
    return np.array(base_orientation(scene.theta_0, scene.roll), order="C"), Fields(
        direction=np.array(weights.direction, order="C"), factor=np.array(weights.factor, order="C"),
        moment=np.array(weights.moment, order="C"),
    )  # fmt: skip


@lru_cache(maxsize=64)
def _own_weight(key: IdentityKey) -> Fields:
    return _read_row(key.design, None)


def _read_row(design: TrunkDesign, loads: Loads | None) -> Fields:
    """Weights of the one row in arrays of their own."""
    weights = read_fields(design, loads)
    return Fields(
        direction=weights.direction.copy()[None], factor=weights.factor.copy()[None], moment=weights.moment.copy()[None]
    )


def _group(stands: list[Stand]) -> dict[Stand, list[int]]:
    """Rows that stand and are loaded alike."""
    groups: dict[Stand, list[int]] = {}
    for b, stand in enumerate(stands):
        groups.setdefault(stand, []).append(b)
    return groups


def _near(stand: Stand) -> Stand:
    """The stand and loads near these for which starts are solved."""
    force = None if stand.force is None else tuple(round(2 * part) / 2 for part in stand.force)
    down = min(max(_STEP * round(stand.theta_0 / _STEP), -MOST_TURNED), MOST_TURNED)
    return Stand(
        down, 2 * _STEP * round(stand.roll / (2 * _STEP)), round(20 * stand.mass) / 20,
        stand.section, force, stand.force_section,
    )  # fmt: skip
