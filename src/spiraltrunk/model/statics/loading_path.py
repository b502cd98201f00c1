"""Loading path: which cable is loaded when, and the equilibrium with friction at its end.

With friction the equilibrium depends on the order of loading. A path loads the cables one after another from rest under
gravity. From its turn on a cable is held, by length or by tension; before it, and where it has no turn, it is relaxed:
it pays out freely.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import Any, final

import numpy as np
from numpy.typing import ArrayLike

from spiraltrunk.checks import broadcast_batches, check_type, read_numbers
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import ModelError
from spiraltrunk.model.jit import share
from spiraltrunk.model.kinematics.shape import Forces, History, Shape
from spiraltrunk.model.statics import equilibrium
from spiraltrunk.model.statics.equilibrium import StaticsOptions
from spiraltrunk.model.statics.loads import Loads, read_angle

__all__ = ["LoadingPath", "load_along"]


@final
@dataclass(frozen=True, kw_only=True, repr=False)
class LoadingPath:
    """Order in which cables are loaded, and how they are held then; leading axes ``...`` are those of the batch."""

    order: np.ndarray
    """Index of the cable that is loaded first, second and so on, -1 for none, shape (..., n_cable) [-]."""
    pull: np.ndarray
    """Cable pulled in since the straight trunk, of cables held by length, else 0, shape (..., n_cable) [m]."""
    tension: np.ndarray
    """Tension of a cable held by tension, largest tension of one held by length, shape (..., n_cable) [N]."""
    by_tension: np.ndarray
    """Which cables are held by tension, those without a turn by 0 N, shape (..., n_cable) [bool]."""

    def __post_init__(self) -> None:
        for field in fields(self):
            object.__setattr__(self, field.name, np.asarray(getattr(self, field.name)))
        shape = self.order.shape
        for name in ("pull", "tension", "by_tension"):
            given = getattr(self, name).shape
            if given != shape:
                raise ModelError(f"{name} of the loading path has shape {given}; allowed: that of its order, {shape}")
        if not shape or self.order.dtype.kind not in "iu" or self.by_tension.dtype != bool:
            raise ModelError("order or by_tension of the loading path is wrong; allowed: integers, booleans")
        if self.order.size and not -1 <= self.order.min() <= self.order.max() < shape[-1]:
            raise ModelError(f"order of the loading path is out of range; allowed: -1 to {shape[-1] - 1}")
        ranked = np.sort(self.order, axis=-1)
        if ((ranked[..., 1:] == ranked[..., :-1]) & (ranked[..., 1:] >= 0)).any():
            raise ModelError("order of the loading path has a cable twice; allowed: each cable once")

    def __repr__(self) -> str:
        if self.order.ndim > 1:
            return f"LoadingPath(batch {self.order.shape[:-1]}, {self.order.shape[-1]} cables)"
        turns = [
            f"cable {c} to {self.tension[c]:.3g} N" if self.by_tension[c] else f"cable {c} by {self.pull[c]:.3g} m"
            for c in self.order[self.order >= 0]
        ]
        return f"LoadingPath({', then '.join(turns) or 'rest'})"


def load_along(
    design: TrunkDesign,
    path: LoadingPath,
    *,
    theta_0: ArrayLike = math.pi / 2,
    roll: ArrayLike = 0.0,
    loads: Loads | None = None,
    friction: float | None = None,
    options: StaticsOptions | None = None,
) -> Shape:
    """Equilibrium at the end of a loading path: one `statics.solve` per turn, each from the solution before it.

    Args:
        design: the trunk.
        path: the order, and how each cable is held.
        theta_0: angle of the base axis below the horizontal, shape (...) [rad].
        roll: rotation of the trunk about its base axis, shape (...) [rad].
        loads: loads besides its weight; they act from the start.
        friction: coefficient between cables and holes [-]; None takes the design's.
        options: options of the model and the solver.

    Raises:
        ModelError: for wrong shapes, and numbers that are not finite or out of range.
        DesignError: for arguments of another type.
    """
    check_type("design", design, TrunkDesign)
    check_type("path", path, LoadingPath)
    if path.order.shape[-1] != design.n_cable:
        raise ModelError(f"the loading path has {path.order.shape[-1]} cables; allowed: the design's {design.n_cable}")
    rows, batch = _read_rows(path, (theta_0, roll), Loads() if loads is None else loads)
    found: list[Any] = [None] * len(rows)

    def load(first: int, last: int) -> None:
        for b in range(first, last):
            found[b] = _load_row(design, *rows[b], friction=friction, options=options)

    share(load, len(rows), 1)
    return _stack(found, batch)


def _read_rows(
    path: LoadingPath, base: tuple[ArrayLike, ArrayLike], loads: Loads
) -> tuple[list[tuple[LoadingPath, dict[str, Any]]], tuple[int, ...]]:
    """Path, base pose and loads of every row, and the batch axes of all together."""
    check_type("loads", loads, Loads)
    parts = [read_angle("theta_0", base[0]), read_angle("roll", base[1]), read_numbers("loads.mass", loads.mass)]
    force = np.zeros(3) if loads.force is None else read_numbers("loads.force", loads.force, shape=(..., 3))
    held = [getattr(path, field.name) for field in fields(path)]
    names = ("theta_0", "roll", "loads.mass", "loads.force", "path")
    own = [*(part.shape for part in parts), force.shape[:-1], path.order.shape[:-1]]
    batch = broadcast_batches(dict(zip(names, own, strict=True)))
    down, turn, mass = (np.broadcast_to(part, batch).ravel().tolist() for part in parts)
    size = path.order.shape[-1]
    force = np.broadcast_to(force, (*batch, 3)).reshape(-1, 3)
    held = [np.broadcast_to(array, (*batch, size)).reshape(-1, size) for array in held]
    rows = []
    for b in range(math.prod(batch)):
        own_force = None if loads.force is None else force[b]
        hung = Loads(mass=mass[b], section=loads.section, force=own_force, force_section=loads.force_section)
        one = LoadingPath(order=held[0][b], pull=held[1][b], tension=held[2][b], by_tension=held[3][b])
        rows.append((one, {"theta_0": down[b], "roll": turn[b], "loads": hung}))
    return rows, batch


def _load_row(design: TrunkDesign, path: LoadingPath, stand: dict[str, Any], **model: Any) -> Shape:
    """`load_along` of one row."""
    order = path.order[path.order >= 0]
    is_relaxed = np.full(path.order.size, True)
    shape = None if order.size else equilibrium.solve(design, **stand, **model)
    for cable in order:
        is_relaxed[cable] = False
        shape = equilibrium.solve(
            design, pull=path.pull, tension=np.where(is_relaxed, 0.0, path.tension),
            by_tension=path.by_tension | is_relaxed, start=shape, **stand, **model,
        )  # fmt: skip
    assert shape is not None  # There is a turn, or rest.
    return shape


def _stack(shapes: list[Any], batch: tuple[int, ...]) -> Any:
    """One batch of single shapes, or of parts of them."""
    if not batch:
        return shapes[0]
    parts = {}
    for field in fields(shapes[0]):
        each = [getattr(shape, field.name) for shape in shapes]
        if isinstance(each[0], Forces | History):
            parts[field.name] = _stack(each, batch)
        else:
            parts[field.name] = np.stack(each).reshape(*batch, *np.shape(each[0]))
    return type(shapes[0])(**parts)
