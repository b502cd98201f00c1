"""A step of the assembly guide, and what the steps are written from."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple, final

from spiraltrunk.cad.components.fasteners import THREADS
from spiraltrunk.cad.components.options import MakeOptions
from spiraltrunk.cad.geometry.part import Part
from spiraltrunk.cad.housing.winder import Drum, find_drum
from spiraltrunk.cad.output.bill_of_materials import Bill
from spiraltrunk.cad.output.guide.tools import find_tools
from spiraltrunk.cad.trunk.body import Body, build_body
from spiraltrunk.cad.trunk.pieces import plan_planes
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.field_docs import explain_fields


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class Step:
    """One step; the guide orders nothing itself, a test proves that no step needs what a later one makes."""

    title: str
    """What is done."""
    needs: tuple[str, ...] = ()
    """Results of earlier steps."""
    makes: tuple[str, ...]
    """Its results."""
    takes: tuple[str, ...] = ()
    """Places in the bill whose items it uses up."""
    work: tuple[str, ...]
    """What to do, in order."""
    check: str
    """How to see that it is done."""

    @property
    def tools(self) -> tuple[str, ...]:
        """The tools that its sentences name."""
        return find_tools((*self.work, self.check))


@explain_fields
@final
@dataclass(frozen=True)
class Build:
    """What is built: the design, how it is made, its parts and its bill."""

    design: TrunkDesign
    """The robot."""
    options: MakeOptions
    """How the parts are made."""
    parts: tuple[Part, ...]
    """The parts that are made."""
    bill: Bill
    """What is made and bought."""

    @cached_property
    def groups(self) -> frozenset[str]:
        """Groups that are made."""
        return frozenset(part.group for part in self.parts)

    @cached_property
    def body(self) -> Body:
        """Dimensions of the trunk's body."""
        return build_body(self.design, self.options)

    @cached_property
    def drum(self) -> Drum:
        """Dimensions of the drums."""
        return find_drum(self.design, self.options)

    @property
    def has_gripper(self) -> bool:
        """Whether the design has a gripper."""
        return self.design.gripper is not None

    @property
    def n_piece(self) -> int:
        """Number of pieces of the trunk."""
        return len(plan_planes(self.design, self.body, self.options)) - 1

    @property
    def n_shell(self) -> int:
        """Number of shells."""
        return sum(seat is not None for seat in self.body.seats)

    @property
    def dressed(self) -> str:
        """Name of the trunk before it is weighed: with its shells, where it has any."""
        return "trunk with shells" if self.n_shell else "trunk"

    def estimate(self, group: str) -> float:
        """The bill's estimate of the mass of all pieces of a group [g]."""
        names = {part.name for part in self.parts if part.group == group}
        return sum(row.count * row.mass for row in self.bill.made if row.item in names)

    @property
    def pull_wire(self) -> int:
        """Length of a wire that reaches from the tip through trunk, neck and lid, and stands out at both ends [mm]."""
        beyond = 60.0 + 2 * 100.0
        return 50 * math.ceil((1e3 * (self.design.length + self.design.housing.neck_length) + beyond) / 50)


@final
class PlannedStep(NamedTuple):
    """A step that is written only where it is necessary, as parts that are not made may not fit the design."""

    groups: frozenset[str]
    """Groups of parts (`catalogue.GROUPS`) of which one makes the step necessary."""
    write: Callable[[Build], Step]
    """Writes it."""
    applies: Callable[[Build], bool] = lambda build: True
    """Whether the design has such a step; asked where one of the groups is made."""

    def is_necessary(self, build: Build) -> bool:
        """Whether the guide has the step."""
        return bool(self.groups & build.groups) and self.applies(build)


def name_key(size: str, *, is_sunk: bool = False, long: float = 0.0) -> str:
    """The hexagon key of a screw, with the length of its longer arm [mm] where a short one does not reach."""
    thread = THREADS[size]
    reach = f", {long:.0f} mm long" if long else ""
    return f"hex key {thread.key_sunk if is_sunk else thread.key:g} mm{reach}"


def name_spanner(size: str) -> str:
    """The spanner of a nut."""
    return f"spanner {THREADS[size].flats:g} mm"


def join(words: Sequence[str]) -> str:
    """Words as a sentence lists them."""
    return " and ".join(filter(None, (", ".join(words[:-1]), *words[-1:])))
