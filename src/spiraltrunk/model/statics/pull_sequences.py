"""The paper's pulls in the static equilibrium: cables pulled one after another.

Each sequence starts at rest under gravity with slack cables. A cable that is not pulled is relaxed: it pays out freely
without tension. With friction the result depends on the order, so each step starts from the solution before it. The
gripper's mass is part of the last section, as in the paper.

All take ``theta_0``, the angle of the base axis below the horizontal [rad], and ``friction``, the coefficient between
cables and holes [-], where None takes the design's. They raise a `ModelError` for numbers that are not finite or out of
range, and for cables that do not fit.
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike

from spiraltrunk.checks import read_numbers
from spiraltrunk.design.trunk import TrunkDesign, ventral_cables
from spiraltrunk.errors import ModelError
from spiraltrunk.model.kinematics import cables
from spiraltrunk.model.kinematics.cables import PULL_MARGIN, pull_range
from spiraltrunk.model.kinematics.shape import Shape
from spiraltrunk.model.reference.constants import check_ventral, prepare, rest_mass
from spiraltrunk.model.statics import equilibrium
from spiraltrunk.model.statics.kernels.laws.joint_limits import NEARLY

LENGTH_TOLERANCE = 1e-6
"""Tolerance of the length of cable 1 in a ventral pull [m]."""

_STEP = 5e-3
"""Largest change of a cable's length per solution without friction [m]; opposed cables may buckle in larger ones."""


@lru_cache(maxsize=16)
def carry_gripper(design: TrunkDesign) -> TrunkDesign:
    """The trunk without gripper whose last section has the gripper's mass too, at its own K_c (authors' code)."""
    if design.gripper is None:
        return design
    mass = tuple(float(value) for value in rest_mass(design))
    return replace(design, gripper=None, mass=replace(design.mass, sections=mass))


def rest(design: TrunkDesign, theta_0: float = math.pi / 2, *, friction: float | None = None) -> Shape:
    """Equilibrium under gravity, cables slack."""
    return equilibrium.solve(carry_gripper(design), theta_0=theta_0, friction=friction)


def pull_tensions(
    design: TrunkDesign, tension: ArrayLike, theta_0: float = math.pi / 2, *, friction: float | None = None
) -> Shape:
    """Equilibrium under tensions at the winders, shape (n_cable,) [N], applied together from rest."""
    return equilibrium.solve(carry_gripper(design), tension=tension, theta_0=theta_0, friction=friction)


def pull_dorsal(
    design: TrunkDesign, pull: float, theta_0: float = math.pi / 2, *, friction: float | None = None
) -> Shape:
    """Equilibrium after cable 1, which must be dorsal, is pulled in from rest, the others relaxed.

    Args:
        design: the trunk.
        pull: shortening of cable 1 from rest, 0 to 1.01 times the stroke [m].
    """
    pull = _read_pull("pull", pull, prepare(design).stroke)
    return _pull_on(design, _rest_alone(design, theta_0, friction), {0: pull}, theta_0, friction)


def pull_ventral(
    design: TrunkDesign, lengthening: float, theta_0: float = math.pi / 2, *, friction: float | None = None
) -> Shape:
    """Equilibrium after the ventral cables are pulled in equally until cable 1 has a given length, all others relaxed.

    The common pull is found by root search, each trial from rest because of friction. Where full curl does not lengthen
    cable 1 that far, the result is full curl.

    Args:
        design: the trunk; cable 1 dorsal, the others mirroring each other, one of them ventral.
        lengthening: lengthening of cable 1 from rest, 0 to 1.01 times that of full curl [m].
    """
    from scipy.optimize import brentq  # Takes 0.3 s: not at the start.

    prepared = prepare(design)
    check_ventral(design, prepared)
    lengthening = _read_pull("lengthening", lengthening, prepared.ventral_stroke)
    start, pulled = _rest_alone(design, theta_0, friction), np.flatnonzero(ventral_cables(design))

    def bend(pull: float) -> Shape:
        return _pull_on(design, start, dict.fromkeys(pulled.tolist(), pull), theta_0, friction)

    def excess(pull: float) -> float:
        return float(start.cable_change[0] - bend(pull).cable_change[0]) - lengthening

    full = np.full((design.n_joint, 2), [0.0, -design.joint_limit])
    most = PULL_MARGIN * float(cables.lengths(design, full).change[pulled].max() - start.cable_change[pulled].min())
    if lengthening == 0.0 or excess(most) <= 0.0:
        return bend(most if lengthening > 0.0 else 0.0)
    return bend(float(brentq(excess, 0.0, most, xtol=LENGTH_TOLERANCE / 10)))


def pull_twist(
    design: TrunkDesign, pull_1: float, pull_2: float, theta_0: float = math.pi / 2, *, friction: float | None = None
) -> Shape:
    """Equilibrium after cable 1 is pulled in from rest and held, and then cable 2, the others relaxed.

    Args:
        design: the trunk; cable 1 dorsal, three cables or more.
        pull_1: shortening of cable 1 from rest, 0 to 1.01 times the stroke [m].
        pull_2: shortening of cable 2 from its length after that, 0 to 1.01 times the stroke [m].
    """
    if design.n_cable < 3:
        raise ModelError(f"the design has {design.n_cable} cables; allowed for a twist: three or more")
    stroke = prepare(design).stroke
    first, second = _read_pull("pull_1", pull_1, stroke), _read_pull("pull_2", pull_2, stroke)
    start = pull_dorsal(design, first, theta_0, friction=friction)
    return _pull_on(design, start, {0: 0.0, 1: second}, theta_0, friction)


def pull_cables(
    design: TrunkDesign, change: ArrayLike, theta_0: float = math.pi / 2, *, friction: float | None = None
) -> Shape:
    """Equilibrium after cables are pulled in together, from rest, to given lengths.

    Args:
        design: the trunk.
        change: straight length minus new length, 0 for a relaxed cable, shape (n_cable,) [m].
    """
    allowed = pull_range(design.cable_stroke)
    final = read_numbers("change", change, allowed, shape=(design.n_cable,), unit="m")
    start = _rest_alone(design, theta_0, friction)
    more = {int(cable): float(final[cable] - start.cable_change[cable]) for cable in np.flatnonzero(final)}
    return _pull_on(design, start, more, theta_0, friction)


def wind_cables(
    design: TrunkDesign,
    pull: ArrayLike,
    theta_0: float = math.pi / 2,
    roll: float = 0.0,
    *,
    friction: float | None = None,
    start: Shape | None = None,
) -> Shape:
    """Equilibrium after all winders have turned together to given lengths.

    A cable that is let out farther than the trunk needs is slack and has no tension. Without friction the lengths
    change in steps of at most 5 mm, in proportion.

    Args:
        design: the trunk.
        pull: straight length minus length of each cable, negative for one that is let out, shape (n_cable,) [m].
        theta_0: angle of the base axis below the horizontal [rad].
        roll: rotation of the trunk about its base axis [rad].
        friction: coefficient between cables and holes [-]; None takes the design's.
        start: an earlier shape of this design, from which the winders turn; None starts at rest with slack cables.
    """
    final = read_numbers("pull", pull, shape=(design.n_cable,), unit="m")
    trunk, mu = carry_gripper(design), design.cable.friction if friction is None else friction
    shape = equilibrium.solve(trunk, theta_0=theta_0, roll=roll, friction=mu) if start is None else start
    begin = shape.cable_change
    if shape.forces is not None:  # A slack cable that is let out moves nothing.
        begin = np.where((shape.forces.cable_tension == 0.0) & (final < begin), final, begin)
    steps = 1 if mu > 0 else max(1, math.ceil(float(np.abs(final - begin).max()) / _STEP - 1e-9))
    for step in range(1, steps + 1):
        shape = equilibrium.solve(
            trunk, pull=begin + (final - begin) * (step / steps), theta_0=theta_0, roll=roll, friction=mu, start=shape
        )
    return shape


def find_shut(design: TrunkDesign, shape: Shape) -> np.ndarray:
    """Which joints are at their limit, by contact of the faces or a closed gap, shape (..., n_joint) [bool]."""
    return shape.is_shut | (shape.joint_angle > design.joint_limit - NEARLY)


def _read_pull(name: str, value: float, full: float) -> float:
    return float(read_numbers(name, value, pull_range(full), shape=(), unit="m"))


def _rest_alone(design: TrunkDesign, theta_0: float, friction: float | None) -> Shape:
    """Rest of one trunk; a batch is refused."""
    return rest(design, float(read_numbers("theta_0", theta_0, shape=())), friction=friction)


def _pull_on(
    design: TrunkDesign, start: Shape, more: dict[int, float], theta_0: float, friction: float | None
) -> Shape:
    """Equilibrium after the cables of ``more`` are pulled in further by these lengths [m], all others relaxed."""
    relaxed = np.ones(design.n_cable, bool)
    relaxed[list(more)] = False
    begin, final = start.cable_change, start.cable_change.copy()
    for cable, pull in more.items():
        final[cable] += pull
    final = np.minimum(final, PULL_MARGIN * design.cable_stroke)  # Beyond full curl nothing moves.
    trunk, mu = carry_gripper(design), design.cable.friction if friction is None else friction
    steps = 1 if mu > 0 else max(1, math.ceil(float(np.abs(final - begin)[~relaxed].max(initial=0.0)) / _STEP - 1e-9))
    shape, tension = start, np.where(relaxed, 0.0, design.cable.tension_max)
    for step in range(1, steps + 1):
        shape = equilibrium.solve(
            trunk, pull=begin + (final - begin) * (step / steps), tension=tension, by_tension=relaxed, theta_0=theta_0,
            friction=friction, start=shape,
        )  # fmt: skip
    return shape
