"""Catalogue of all parts by group."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from spiraltrunk.cad.components.options import MakeOptions
from spiraltrunk.cad.geometry.part import Part
from spiraltrunk.cad.housing.housing import build_adapter, build_housing
from spiraltrunk.cad.housing.test_stand import build_markers, build_wedge
from spiraltrunk.cad.housing.winder import build_drums, build_horn
from spiraltrunk.cad.trunk.gripper import build_gripper
from spiraltrunk.cad.trunk.pieces import build_trunk
from spiraltrunk.cad.trunk.skin import build_moulds, build_shells
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import UnknownName

GROUPS: dict[str, Callable[[TrunkDesign, MakeOptions], tuple[Part, ...]]] = {
    "trunk": build_trunk,
    "gripper": build_gripper,
    "shells": build_shells,
    "moulds": build_moulds,
    "housing": build_housing,
    "drums": build_drums,
    "horn": build_horn,
    "adapter": build_adapter,
    "wedge": build_wedge,
    "markers": build_markers,
}
"""Builder of each group of parts from a design and options."""


def check_groups(names: Sequence[str]) -> tuple[str, ...]:
    """The selected groups in the order of the catalogue; "all" selects all.

    Raises:
        UnknownName: lists the groups.
    """
    for name in names:
        if name not in GROUPS and name != "all":
            raise UnknownName("part", name, ("all", *GROUPS))
    return tuple(GROUPS) if "all" in names else tuple(name for name in GROUPS if name in names)


def build_parts(design: TrunkDesign, names: Sequence[str], options: MakeOptions) -> tuple[Part, ...]:
    """Definitions of all parts in the groups; a trunk without gripper has no parts for one.

    Raises:
        UnknownName: for a group that does not exist.
        DesignError: where the design has no room for a part.
    """
    return tuple(part for name in check_groups(names) for part in GROUPS[name](design, options))
