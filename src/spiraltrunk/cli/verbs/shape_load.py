"""What ``spiraltrunk shape`` does to the trunk: the options that pull cables, and the model that answers them."""

from __future__ import annotations

import argparse
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple, final

from spiraltrunk.cli.arguments import Typed
from spiraltrunk.cli.output import UsageError

if TYPE_CHECKING:
    from spiraltrunk.design import TrunkDesign
    from spiraltrunk.model.kinematics.shape import Shape

MODELS = ("reference", "statics")
"""Models by name."""


@final
class LoadSpec(NamedTuple):
    """One option that pulls cables."""

    option: str
    numbers: int | str
    metavar: str | tuple[str, ...]
    models: tuple[str, ...]
    help: str


LOADS = {
    "dorsal": LoadSpec("--dorsal-mm", 1, "D", MODELS, "cable 1 pulled in by D from rest, the others relaxed"),
    "ventral": LoadSpec(
        "--ventral-mm", 1, "D", MODELS,
        "the other cables pulled in equally until cable 1 has lengthened by D from rest",
    ),
    "twist": LoadSpec(
        "--twist-mm", 2, ("D1", "D2"), MODELS,
        "cable 1 pulled in by D1 from rest and held, then cable 2 by D2 from its length at that moment",
    ),
    "cables": LoadSpec(
        "--cables-mm", "+", "C", MODELS[1:],
        "one number per cable, pulled together: straight length minus new length; 0 is relaxed: the cable pays out "
        "freely and bears no tension",
    ),
    "tensions": LoadSpec(
        "--tensions-n", "+", "T", MODELS[1:], "tension of each cable, one number per cable; 0 is relaxed"
    ),
}  # fmt: skip
"""The options by their name in the arguments; each is a load of its own."""


@final
@dataclass(frozen=True, kw_only=True)
class Load:
    """What was typed."""

    name: str
    """Key of LOADS."""
    typed: tuple[Typed, ...]
    """Numbers in the option's unit."""

    @property
    def option(self) -> str:
        """The option as it is typed."""
        return LOADS[self.name].option

    @property
    def meters(self) -> list[float]:
        """Numbers of an option in mm as lengths [m]."""
        return [value / 1e3 for value in self.typed]


def read_load(arguments: argparse.Namespace) -> Load | None:
    """The one load that was typed, None for rest.

    Raises:
        UsageError: where several were typed.
    """
    given = [name for name in LOADS if getattr(arguments, name) is not None]
    if len(given) > 1:
        told = " and ".join(LOADS[name].option for name in given)
        raise UsageError(f"{told} given; allowed: one of {', '.join(spec.option for spec in LOADS.values())}, or none")
    return Load(name=given[0], typed=tuple(getattr(arguments, given[0]))) if given else None


def pick_model(asked: str | None, load: Load | None) -> str:
    """The model asked for, else the first that knows the load.

    Raises:
        UsageError: where the model asked for does not know it.
    """
    known = MODELS if load is None else LOADS[load.name].models
    if asked is not None and asked not in known and load is not None:
        can = ", ".join(spec.option for spec in LOADS.values() if asked in spec.models)
        raise UsageError(f"{load.option} given with --model {asked}; allowed there: {can}; or --model {known[0]}")
    return known[0] if asked is None else asked


def check_load(design: TrunkDesign, load: Load | None) -> None:
    """Refuse numbers that the design's cables cannot be given.

    Raises:
        UsageError: says the option, the number as typed and the range in its unit.
    """
    if load is None:
        return
    count = len(load.typed)
    if load.name in ("cables", "tensions") and count != design.n_cable:
        told = f"{design.n_cable}, one per cable of {design.name!r}"
        raise UsageError(f"{load.option} has {count} number{'s' * (count != 1)}; allowed: {told}")
    most, unit, why = _range(design, load.name)
    for value in load.typed:
        if not 0.0 <= value <= most:
            raise UsageError(f"{load.option} is {value.text}; allowed: 0 to {most:g} {unit}, {why}")


def solve_load(design: TrunkDesign, load: Load | None, model: str, theta_0: float, friction: float | None) -> Shape:
    """The shape by the model's name."""
    if model == "reference":
        return _solve_reference(design, load, theta_0)
    from spiraltrunk.model.statics import pull_sequences

    if load is None:
        return pull_sequences.rest(design, theta_0, friction=friction)
    if load.name == "tensions":
        return pull_sequences.pull_tensions(design, list(map(float, load.typed)), theta_0, friction=friction)
    if load.name == "cables":
        return pull_sequences.pull_cables(design, load.meters, theta_0, friction=friction)
    law = {
        "dorsal": pull_sequences.pull_dorsal,
        "ventral": pull_sequences.pull_ventral,
        "twist": pull_sequences.pull_twist,
    }[load.name]
    return law(design, *load.meters, theta_0, friction=friction)  # type: ignore[operator]


def _solve_reference(design: TrunkDesign, load: Load | None, theta_0: float) -> Shape:
    from spiraltrunk.model import reference

    if load is None:
        return reference.rest(design, theta_0)
    law = {"dorsal": reference.bend_dorsal, "ventral": reference.bend_ventral, "twist": reference.twist}[load.name]
    return law(design, *load.meters, theta_0)  # type: ignore[operator]


def _range(design: TrunkDesign, name: str) -> tuple[float, str, str]:
    """Largest number of the option, rounded down, its unit and what sets it."""
    from spiraltrunk.model.kinematics.cables import PULL_MARGIN
    from spiraltrunk.model.reference.constants import prepare

    if name == "tensions":
        return design.cable.tension_max, "N", "the largest tension of the design's motors"
    full = prepare(design).ventral_stroke if name == "ventral" else design.cable_stroke
    what = "what full curl lengthens cable 1 by" if name == "ventral" else "the cable's stroke"
    return math.floor(PULL_MARGIN * full * 1e4) / 10, "mm", f"{PULL_MARGIN:g} times {what}"
