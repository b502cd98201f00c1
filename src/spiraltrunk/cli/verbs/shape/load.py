"""Loads of ``spiraltrunk shape``: the options that pull cables, and the functions that solve them."""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple, final

from spiraltrunk.cli.arguments import Typed
from spiraltrunk.cli.output import UsageError, format_count
from spiraltrunk.errors import ModelError

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
        "the ventral cables pulled in equally until cable 1 has lengthened by D from rest, the others relaxed",
    ),
    "twist": LoadSpec(
        "--twist-mm", 2, ("D1", "D2"), MODELS,
        "cable 1 pulled in by D1 from rest and held, then cable 2 by D2 from its length at that moment",
    ),
    "cables": LoadSpec(
        "--cables-mm", "+", "C", MODELS[1:],
        "one number per cable, pulled together: straight length minus new length; 0 is relaxed: the cable pays out "
        "freely and has no tension",
    ),
    "tensions": LoadSpec(
        "--tensions-n", "+", "T", MODELS[1:], "tension of each cable, one number per cable; 0 is relaxed"
    ),
}  # fmt: skip
"""Options by their name in the arguments."""


@final
@dataclass(frozen=True, kw_only=True)
class Load:
    """A load as typed."""

    name: str
    """Key of LOADS."""
    typed: tuple[Typed, ...]
    """Numbers in the option's unit."""

    @property
    def option(self) -> str:
        """The option."""
        return LOADS[self.name].option

    @property
    def text(self) -> str:
        """Option and numbers as they were typed."""
        return f"{self.option} {' '.join(value.text for value in self.typed)}"

    @property
    def numbers(self) -> list[float]:
        """The numbers."""
        return [float(value) for value in self.typed]


def read_load(arguments: argparse.Namespace) -> Load | None:
    """The load in the arguments, None for rest.

    Raises:
        UsageError: for several loads.
    """
    given = [name for name in LOADS if getattr(arguments, name) is not None]
    if len(given) > 1:
        options = " and ".join(LOADS[name].option for name in given)
        allowed = f"one of {', '.join(spec.option for spec in LOADS.values())}, or none"
        raise UsageError(f"{options} given; allowed: {allowed}")
    return Load(name=given[0], typed=tuple(getattr(arguments, given[0]))) if given else None


def pick_model(asked: str | None, load: Load | None) -> str:
    """The model asked for, or the first that can solve the load.

    Raises:
        UsageError: where the model asked for cannot solve the load.
    """
    known = MODELS if load is None else LOADS[load.name].models
    if asked is not None and asked not in known and load is not None:
        can = ", ".join(spec.option for spec in LOADS.values() if asked in spec.models)
        raise UsageError(f"{load.option} given with --model {asked}; allowed there: {can}; or --model {known[0]}")
    return known[0] if asked is None else asked


def solve_load(design: TrunkDesign, load: Load | None, model: str, theta_0: float, friction: float | None) -> Shape:
    """The shape by the model.

    Raises:
        ModelError: for numbers that the model refuses, with the option as typed.
    """
    if load is not None and LOADS[load.name].numbers == "+" and len(load.typed) != design.n_cable:
        allowed = f"{design.n_cable}, one for each cable of {design.name!r}"
        raise ModelError(f"{load.text}: {format_count(len(load.typed), 'number')} given; allowed: {allowed}")
    try:
        return _solve_reference(design, load, theta_0) if model == "reference" else _solve_statics(
            design, load, theta_0, friction
        )  # fmt: skip
    except ModelError as error:
        option = "" if load is None else f"{load.text}: "
        from spiraltrunk.checks import OutOfRange

        told = error.outside
        in_mm = told.in_unit("mm", 1e-3) if isinstance(told, OutOfRange) and told.unit == "m" else error
        raise ModelError(f"{option}{in_mm}") from None


def _solve_statics(design: TrunkDesign, load: Load | None, theta_0: float, friction: float | None) -> Shape:
    from spiraltrunk.model.statics import pull_sequences

    if load is None:
        return pull_sequences.rest(design, theta_0, friction=friction)
    lengths = [value / 1e3 for value in load.numbers]
    if load.name == "tensions":
        return pull_sequences.pull_tensions(design, load.numbers, theta_0, friction=friction)
    if load.name == "cables":
        return pull_sequences.pull_cables(design, lengths, theta_0, friction=friction)
    pull = {
        "dorsal": pull_sequences.pull_dorsal,
        "ventral": pull_sequences.pull_ventral,
        "twist": pull_sequences.pull_twist,
    }[load.name]
    return pull(design, *lengths, theta_0, friction=friction)  # type: ignore[operator]


def _solve_reference(design: TrunkDesign, load: Load | None, theta_0: float) -> Shape:
    from spiraltrunk.model import reference

    if load is None:
        return reference.rest(design, theta_0)
    bend = {"dorsal": reference.bend_dorsal, "ventral": reference.bend_ventral, "twist": reference.twist}[load.name]
    return bend(design, *(value / 1e3 for value in load.numbers), theta_0)  # type: ignore[operator]
