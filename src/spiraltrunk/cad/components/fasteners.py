"""Screws, nuts and pins as they are bought, and the room that they take once they are in place. In mm."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from spiraltrunk.cad.geometry.csg import Form, Prism, Revolved, rod

M3, M4, M6 = 3.4, 4.5, 6.6
"""Holes that screws pass (ISO 273, medium)."""

M3_INSERT, M4_INSERT = 4.0, 5.6
"""Holes for heat-set inserts (as their makers state them)."""

M6_HEAD = 11.0
"""Counterbore of an M6 socket head (DIN 974)."""

LENGTHS = (6.0, 8.0, 10.0, 12.0, 16.0, 20.0, 25.0, 30.0, 35.0, 40.0, 45.0, 50.0, 55.0, 60.0, 70.0, 80.0, 100.0)
"""Lengths that screws come in (ISO 4762)."""


@final
@dataclass(frozen=True, kw_only=True)
class Thread:
    """What belongs to one size of thread."""

    name: str
    """What to ask for."""
    shaft: float
    """Diameter of the thread."""
    head: float
    """Diameter of a socket head (ISO 4762); a sunk head (ISO 10642) is `sunk` wide."""
    head_height: float
    """Height of a socket head."""
    sunk: float
    """Diameter of a sunk head, as it is made."""
    flats: float
    """Width of a nut across its flats (ISO 4032)."""
    nut: float
    """Height of a nut, at most."""


THREADS = {
    "M3": Thread(name="M3", shaft=3.0, head=5.5, head_height=3.0, sunk=5.5, flats=5.5, nut=2.4),
    "M4": Thread(name="M4", shaft=4.0, head=7.0, head_height=4.0, sunk=7.5, flats=7.0, nut=3.2),
    "M6": Thread(name="M6", shaft=6.0, head=10.0, head_height=6.0, sunk=11.1, flats=10.0, nut=5.2),
}
"""The sizes that are used."""


@final
@dataclass(frozen=True, kw_only=True)
class Bolt:
    """One screw in its place in the assembled robot."""

    what: str
    """What it joins."""
    parts: tuple[str, ...]
    """Names of the parts that it goes through or into."""
    thread: Thread
    """Its size."""
    seat: tuple[float, float, float]
    """Where the axis goes through the plane that its head lies on; of a sunk head, the plane that it is flush with."""
    along: tuple[float, float, float]
    """Unit vector from head to end."""
    length: float
    """Length below that plane."""
    is_sunk: bool = False
    """Whether its head is sunk."""
    nut_at: float | None = None
    """From the seat to the near face of its nut; None where an insert, a thread or a motor holds it."""
    is_nut_trapped: bool = False
    """Whether the nut lies in a pocket of its own shape."""
    is_head_elsewhere: bool = False
    """Whether the head lies on a part that is not among those that are looked at."""
    way: float = 0.0
    """How far a straight key must come to the head while the parts are put together."""

    def forms(self) -> tuple[Form, ...]:
        """Head, shaft and nut."""
        seat, along = np.array(self.seat), np.array(self.along)
        t = self.thread
        bodies = [rod(t.shaft / 2, self.seat, seat + self.length * along)]
        if not self.is_sunk:
            bodies.append(rod(t.head / 2, seat - t.head_height * along, self.seat))
        if self.nut_at is not None:
            start = seat + self.nut_at * along
            wide = t.flats / 2 if self.is_nut_trapped else t.flats / math.sqrt(3)
            bodies.append(rod(wide, start, start + t.nut * along))
        return tuple(bodies)

    def key(self) -> Form | None:
        """The way of the key to the head."""
        if not self.way:
            return None
        top = np.array(self.seat) - (0.0 if self.is_sunk else self.thread.head_height) * np.array(self.along)
        return rod(self.thread.head / 2, top - self.way * np.array(self.along), top)


def pick_length(most: float) -> float | None:
    """The longest screw that is no longer than that; None where there is none."""
    fitting = [length for length in LENGTHS if length <= most]
    return fitting[-1] if fitting else None


def sink(thread: Thread, hole: float, extra: float = 0.3) -> Form:
    """What is cut for a sunk head, from below z = 0 up: a cone of 90 deg."""
    wide = thread.sunk / 2 + extra
    deep = wide - hole / 2 + 0.1
    return Revolved(profile=((0.0, -0.5), (wide, -0.5), (wide, 0.0), (hole / 2 - 0.1, deep), (0.0, deep)))


def hexagon(flats: float, place: Sequence[float], top: float) -> Form:
    """A pocket for a nut, from its floor at ``place`` to ``top``, one flat towards the axis."""
    x, y, z = place
    corner, first = flats / math.sqrt(3), math.atan2(y, x) + math.pi / 6
    turns = [first + k * math.pi / 3 for k in range(6)]
    return Prism(
        corners=tuple((x + corner * math.cos(turn), y + corner * math.sin(turn)) for turn in turns), bottom=z, top=top
    )
