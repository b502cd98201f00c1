"""Tools of the guide: what its sentences may name, so that a step lists the tools that it uses and no other."""

from __future__ import annotations

import re
from collections.abc import Iterable

_SIZED = (
    r"hex key [\d.]+ mm(?:, \d+ mm long)?",
    r"spanner [\d.]+ mm",
    r"drill [\d.]+ mm",
    r"spring steel wire [\d.]+ mm",
    r"soft steel wire [\d.]+ mm(?:, \d+ mm long)?",
    r"weight of \d+ g",
    r"blocks of \d+ mm",
)
"""Patterns of tools that come in sizes."""

_NAMED = (
    "3D printer",
    "angle gauge",
    "bench supply",
    "calliper",
    "cold metal plate",
    "computer with USB",
    "crimping pliers",
    "crimping tool",
    "cups and spatulas",
    "cyanoacrylate glue",
    "electrical tape",
    "flat table",
    "flush cutter",
    "Linux computer",
    "luggage scale",
    "masking tape",
    "multimeter",
    "nitrile gloves",
    "pen",
    "pin vice",
    "rubber bands",
    "safety glasses",
    "scale to 0.1 g",
    "scale to 10 g",
    "scissors for braid",
    "second person",
    "sewing thread",
    "slicer with modifier bodies",
    "soft jaws",
    "soldering iron with insert tip",
    "soldering iron",
    "spirit level",
    "small screwdriver",
    "straight edge",
    "strip of paper",
    "tray",
    "tweezers",
    "vacuum chamber",
    "water with a drop of dish soap",
)
"""Tools of one size."""

_TOOL = re.compile("|".join([*_SIZED, *(rf"\b{re.escape(name)}\b" for name in sorted(_NAMED, key=len, reverse=True))]))


def find_tools(sentences: Iterable[str]) -> tuple[str, ...]:
    """The tools that sentences name, in the order in which they are named, each once."""
    return tuple(dict.fromkeys(match.group() for text in sentences for match in _TOOL.finditer(text)))
