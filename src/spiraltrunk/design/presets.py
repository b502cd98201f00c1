"""Named designs."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import cache

from spiraltrunk.design.gripper import GripperDesign
from spiraltrunk.design.parts import CableDesign, JointDesign, MassDesign
from spiraltrunk.design.rules import design_from_rules
from spiraltrunk.design.sizing import design_from_sizes
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import UnknownName

_PAPER_SECTION_MASS_G = (
    33.0, 26.0, 21.3, 20.4, 14.2, 11.3, 9.7, 7.7, 9.7, 8.5, 7.0, 5.6, 4.7, 3.5, 3.0, 2.3, 2.0, 1.4
)  # fmt: skip
"""Masses of the sections [g] (authors' code, sections 2 to 18; section 1 extrapolated by k_p^-3)."""

_PAPER_CENTER_FRACTION = 26.749 / 47.94
"""Centre of mass over section length, K_c [-] (authors' code)."""


def _build_paper() -> TrunkDesign:
    masses = tuple(float(f"{grams}e-3") for grams in _PAPER_SECTION_MASS_G)
    measured = MassDesign(sections=masses, center_fraction=_PAPER_CENTER_FRACTION)
    joint = JointDesign(radius=3.825e-3, length=2.10e-3)
    return replace(design_from_rules(b=0.16, name="paper"), joint=joint, mass=measured, gripper=GripperDesign())


PAPER = _build_paper()
"""The robot of "Grasping by Spiraling" with the numbers of the authors' code: b = 0.16, measured section masses."""


LARGE_GRIP = 1.75
"""Finger scale of ``paper-large-grip`` [-] (ours)."""


def _build_large_grip() -> TrunkDesign:
    return replace(PAPER, name="paper-large-grip", gripper=GripperDesign().enlarged(LARGE_GRIP))


def _build_spirob_15() -> TrunkDesign:
    """Planar SpiRob: two cables, 25 cm, tip 5.5 mm, taper 15 deg (Wang et al., SpiRobs); joints like the paper's."""
    planar = CableDesign(angles=(0.0, math.pi))
    design = design_from_sizes(
        tip_width=5.5e-3, length=0.25, taper=math.radians(15.0), cable=planar, name="spirob-15"
    )  # fmt: skip
    return replace(design, gripper=None)


def _build_spirob_1m() -> TrunkDesign:
    """One-metre SpiRob: three cables, tip 5 mm, base 120 mm (Wang et al., SpiRobs); joints scaled from the paper's."""
    design = design_from_sizes(tip_width=5e-3, length=1.0, base_width=0.12, name="spirob-1m")
    return replace(design, gripper=None)


_BUILDERS: dict[str, Callable[[], TrunkDesign]] = {
    "paper": lambda: PAPER,
    "paper-large-grip": _build_large_grip,
    "spirob-15": _build_spirob_15,
    "spirob-1m": _build_spirob_1m,
}

NAMES = tuple(_BUILDERS)
"""Names of the presets."""


@cache
def get(name: str) -> TrunkDesign:
    """The preset called ``name``.

    Raises:
        UnknownName: lists the names.
    """
    if name not in _BUILDERS:
        raise UnknownName("preset", name, NAMES)
    return _BUILDERS[name]()


def find_name(design: TrunkDesign) -> str | None:
    """Name of the preset that a design equals; None where it is a design of one's own."""
    return next((name for name in NAMES if get(name) == design), None)
