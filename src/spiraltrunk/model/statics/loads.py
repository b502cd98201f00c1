"""Inputs of a static equilibrium: cables held by length or tension, loads, orientation of the base."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple, final

import numpy as np
from numpy.typing import ArrayLike

from spiraltrunk.checks import Range, broadcast_batches, check_count, check_number, check_type, read_numbers
from spiraltrunk.design.rules import GRAVITY
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import ModelError, describe
from spiraltrunk.field_docs import explain_fields
from spiraltrunk.model.identity_cache import IdentityKey
from spiraltrunk.model.kinematics.cables import PULL_MARGIN
from spiraltrunk.model.kinematics.shape import MOST_TURNED, Shape


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class Loads:
    """Loads on the trunk besides its weight; arrays broadcast against the batch."""

    mass: ArrayLike = 0.0
    """Mass at the end of a section, shape (...) [kg]."""
    section: int = -1
    """Index of that section, 0 at the base; negative indices count from the tip."""
    force: ArrayLike | None = None
    """Force at the end of a section, in the frame of `Shape`, shape (..., 3) [N]."""
    force_section: int = -1
    """Index of the section on which the force acts."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class QuasiStatic:
    """Quasi-static loading: winders at constant speeds that arrive together, damped joints, no inertia.

    Of several equilibria it finds the one that a slowly pulled trunk reaches. Where all cables pull against each other
    the trunk buckles during loading, and the equilibrium may depend on the speeds. With friction the slip forces lag by
    one time step, of which a loading has at least 2000.
    """

    damping_time: float = 0.04
    """Damping of the joints over their stiffness [s]; only its product with the speeds matters."""
    pull_speed: float = 0.005
    """Change of a cable's length [m/s]."""
    tension_speed: float = 1.0
    """Change of a tension [N/s]."""

    def __post_init__(self) -> None:
        for name in ("damping_time", "pull_speed", "tension_speed"):
            check_number(f"quasi_static.{name}", getattr(self, name), least=1e-6, below=1e6)


@final
class CableInput(NamedTuple):
    """Checked inputs of the cables, shapes (..., n_cable)."""

    pull: np.ndarray
    """Cable pulled in since the straight trunk, of cables held by length [m]."""
    tension: np.ndarray
    """Tension of cables held by tension, largest tension of the others [N]."""
    by_tension: np.ndarray
    """Which cables are held by tension, shape (n_cable,) [bool]."""


@final
class BodyForces(NamedTuple):
    """Constant forces on the sections: gravity on all masses, and the force of the loads."""

    direction: np.ndarray
    """Shape (..., 1 or 2, 3) [m/s^2], [N]."""
    factor: np.ndarray
    """Mass of every section, and 1 where the force acts, shape (..., 1 or 2, n_section) [kg], [-]."""
    moment: np.ndarray
    """The same times its distance along the section, shape (..., 1 or 2, n_section) [kg m], [m]."""


def read_cables(
    design: TrunkDesign, pull: ArrayLike | None, tension: ArrayLike | None, by_tension: ArrayLike | None
) -> CableInput:
    """Check the inputs of the cables; a `ModelError` names the one that does not fit."""
    if pull is None and tension is None and by_tension is None:
        return _slack(IdentityKey(design))
    count, most = design.n_cable, design.cable.tension_max
    if by_tension is None:
        held = np.full(count, pull is None)
    else:
        held = np.array(by_tension)
        if held.shape != (count,) or held.dtype != bool:
            raise ModelError(f"by_tension is {describe(by_tension)}; allowed: {count} booleans, one per cable")
    if pull is None and not all(held.tolist()):
        raise ModelError("pull is missing; allowed: a pull wherever by_tension is False")
    farthest = PULL_MARGIN * design.cable_stroke
    given = np.where(held, 0.0, most) if tension is None else tension
    return CableInput(
        _read_cables("pull", 0.0 if pull is None else pull, count, Range(least=-farthest, most=farthest), "m"),
        _read_cables("tension", given, count, Range(least=0.0, most=most), "N"),
        held,
    )


def read_forces(design: TrunkDesign, loads: Loads | None) -> BodyForces:
    """Weight of the sections and the loads, checked: at most 1000 kg and 10 kN, on sections that exist."""
    if loads is None:
        return _own_weight(IdentityKey(design))
    check_type("loads", loads, Loads)
    mass = read_numbers("loads.mass", loads.mass, Range(least=0.0, most=1e3), unit="kg")
    at = _read_section(design, "loads.section", loads.section)
    factor = np.broadcast_to(design.section_mass, (*mass.shape, design.n_section)).copy()
    moment = factor * design.section_center
    factor[..., at] += mass
    moment[..., at] += mass * design.section_length[at]
    direction = np.broadcast_to([0.0, -GRAVITY, 0.0], (*mass.shape, 3))
    if loads.force is None:
        return BodyForces(direction[..., None, :], factor[..., None, :], moment[..., None, :])
    force = read_numbers("loads.force", loads.force, Range(least=-1e4, most=1e4), shape=(..., 3), unit="N")
    end = np.zeros(design.n_section)
    end[_read_section(design, "loads.force_section", loads.force_section)] = 1.0
    batch = broadcast_batches({"loads.mass": mass.shape, "loads.force": force.shape[:-1]})
    pairs = (direction, force), (factor, end), (moment, end * design.section_length)
    return BodyForces(*(_stack_fields(first, second, batch) for first, second in pairs))


def read_angle(name: str, value: ArrayLike) -> np.ndarray:
    """An array of angles, checked to be within 1e6 rad of 0 [rad]."""
    return read_numbers(name, value, Range(least=-MOST_TURNED, most=MOST_TURNED), unit="rad")


def check_start(design: TrunkDesign, start: Shape) -> None:
    """Refuse a start of another trunk, or with numbers that are not finite, by a `ModelError` that names the array."""
    read_numbers("start.gap", start.gap, shape=(..., design.n_joint, design.n_cable))
    if start.history is not None:
        read_numbers("start.history.bend", start.history.bend)
        read_numbers("start.history.anchor", start.history.anchor)
    if start.forces is not None:
        read_numbers("start.forces.cable_tension", start.forces.cable_tension)


@lru_cache(maxsize=64)
def _slack(key: IdentityKey[TrunkDesign]) -> CableInput:
    none = np.zeros(key.value.n_cable)
    return CableInput(none, none, np.full(none.size, True))


@lru_cache(maxsize=64)
def _own_weight(key: IdentityKey[TrunkDesign]) -> BodyForces:
    return read_forces(key.value, Loads())


def _read_cables(name: str, value: ArrayLike, count: int, allowed: Range, unit: str) -> np.ndarray:
    """One number per cable; a single number holds for all of them."""
    array = read_numbers(name, value, allowed, unit=unit)
    if array.shape == (count,):
        return array
    if array.shape[-1:] not in ((count,), ()):
        raise ModelError(f"{name} has shape {array.shape}; allowed: (..., {count}), one number per cable")
    return np.broadcast_to(array, (*array.shape[:-1], count)) if array.ndim else np.full(count, float(array))


def _read_section(design: TrunkDesign, name: str, section: int) -> int:
    check_count(name, section, least=-design.n_section, most=design.n_section - 1)
    return int(section) % design.n_section


def _stack_fields(first: np.ndarray, second: np.ndarray, batch: tuple[int, ...]) -> np.ndarray:
    return np.stack([np.broadcast_to(part, (*batch, first.shape[-1])) for part in (first, second)], axis=-2)
