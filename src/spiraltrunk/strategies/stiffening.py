"""Stiffening of a grasp for transport: length control of the winders, and co-contraction of opposing cables.

"Grasping by Spiraling" (Results, transport) stiffens the trunk by opposing tensions of dorsal and ventral cables. The
equilibrium and the simulation find (docs/validation/stiffness.md): cables held by tension without friction soften the
trunk when they oppose; cables held by length stiffen it, whatever their tension; only friction in the holes makes
stiffness grow with tension.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from spiraltrunk.checks import check_number
from spiraltrunk.design.trunk import TrunkDesign, ventral_cables
from spiraltrunk.errors import ModelError
from spiraltrunk.model.kinematics.cables import planar_lever
from spiraltrunk.strategies.moves import Move, MoveSequence, edit_moves

CEILING = 0.95
"""Tension over the largest one that a winder may take to hold its length [-] (ours): the rest is left to move."""

COMPLIANCE = 5e-5
"""Cable that a winder pays out over its tension while it holds a length [m/N], of the simulated winder."""

TAUT = 1.0
"""Tension of a dorsal cable that is just taut [N] (ours)."""

AGAINST = 0.1
"""Dorsal tension over the ventral one where cables rub [-] (ours)."""


def co_contraction(design: TrunkDesign, ventral: float, dorsal: float, bend: float = 0.0) -> np.ndarray:
    """Tensions of opposing cables that bend the trunk as the ventral ones alone do, shape (n_cable,) [N].

    Each ventral cable takes in addition the tension that balances the dorsal cables' moment about a joint,

        dT_ventral = T_dorsal * sum lever_dorsal(bend) / -sum lever_ventral(bend),

    which is the same at every joint of that bend, as the sections are similar. The shape is kept where all joints bend
    alike; the half curled trunk of the paper shifts by 13 mm at 5 N, without friction. With friction these are the
    tensions that result from bending, holding the ventral lengths and then pulling dorsal, in this order.

    Args:
        design: trunk with cables on both sides.
        ventral: tension of each ventral cable alone [N].
        dorsal: tension of each dorsal cable [N].
        bend: ventral bend of the joints that keep their moment [rad].

    Raises:
        DesignError: for a tension that is negative, or a bend beyond the joint limit.
        ModelError: where the cables are not on both sides, or a motor cannot pull so hard.
    """
    check_number("ventral", ventral, least=0.0)
    check_number("dorsal", dorsal, least=0.0)
    check_number("bend", bend, least=0.0, most=design.joint_limit)
    pulls_ventral, pulls_dorsal = ventral_cables(design), design.cable_direction[:, 1] > 1e-6
    if not (pulls_ventral.any() and pulls_dorsal.any()):
        raise ModelError("cables pull to one side alone; allowed: a design with dorsal and ventral cables")
    lever = planar_lever(design, np.full(design.n_joint, -bend))[0]
    more = dorsal * lever[pulls_dorsal].sum() / -lever[pulls_ventral].sum()
    tension = np.where(pulls_ventral, ventral + more, np.where(pulls_dorsal, dorsal, 0.0))
    if tension.max() > design.cable.tension_max:
        allowed = f"{design.cable.tension_max:g} N, the motors' largest"
        raise ModelError(f"ventral tension with {dorsal:g} N against it is {tension.max():.3g} N; allowed: {allowed}")
    return tension


def hold_lengths(
    design: TrunkDesign, pull: np.ndarray, tension: np.ndarray, *, dorsal: float = 0.0
) -> tuple[np.ndarray, np.ndarray]:
    """Bounds of pulls and tensions with which the ventral winders keep their present lengths.

    Args:
        design: the trunk.
        pull: present cable pulls, shape (n_cable,) [m].
        tension: present tensions, shape (n_cable,) [N].
        dorsal: tension of the dorsal cables from now on, whatever their length, at most the motors' largest [N].

    Returns:
        ``cable_pull`` and ``cable_tension`` of the commands to come, shapes (n_cable,) [m], [N].
    """
    ventral = ventral_cables(design)
    ceiling = np.where(ventral, CEILING * design.cable.tension_max, dorsal)
    ceiling[~ventral & (design.cable_direction[:, 1] <= 1e-6)] = 0.0
    return np.where(ventral, pull + COMPLIANCE * tension, np.inf), ceiling


def counter_tension(design: TrunkDesign, ventral: float) -> float:
    """Tension of the dorsal cables against ventral ones of tension ``ventral``, whose lengths are held [N].

    They are just taut where cables run freely, as more tension would soften the trunk. Where cables rub, they take a
    tenth of the ventral tension (docs/validation/stiffness.md).
    """
    return max(TAUT, AGAINST * ventral if design.cable.friction > 0 else 0.0)


def hold_lengths_in(
    sequence: MoveSequence, actions: tuple[str, ...], pull: np.ndarray, tension: np.ndarray
) -> MoveSequence:
    """The sequence with bounds as of `hold_lengths` in all moves of these actions, shapes (n_cable,) [m], [N]."""

    def hold(move: Move) -> Move:
        return replace(move, pull=pull, tension=tension) if move.action in actions else move

    return edit_moves(sequence, 0, hold)
