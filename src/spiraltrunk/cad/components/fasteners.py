"""Screws and nuts: standard dimensions, and the volumes that they occupy in place. In mm."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from spiraltrunk.cad.geometry.csg import Form, Prism, Revolved, rod

M3, M4, M6 = 3.4, 4.5, 6.6
"""Clearance holes (ISO 273, medium)."""

M3_INSERT, M4_INSERT = 4.0, 5.6
"""Holes for heat-set inserts (makers' data)."""

M3_INSERT_DEEP, M4_INSERT_DEEP = 8.0, 8.5
"""Depths of these holes (ours: inserts of at most 6 and 8.1 mm, with room for what melts)."""

M6_HEAD = 11.0
"""Counterbore of an M6 socket head (DIN 974)."""

LENGTHS = (6.0, 8.0, 10.0, 12.0, 16.0, 20.0, 25.0, 30.0, 35.0, 40.0, 45.0, 50.0, 55.0, 60.0, 70.0, 80.0, 100.0)
"""Standard lengths of screws (ISO 4762)."""


@final
@dataclass(frozen=True, kw_only=True)
class Thread:
    """Dimensions of one size of thread."""

    name: str
    """Designation."""
    shaft: float
    """Diameter of the thread."""
    head: float
    """Diameter of a socket head (ISO 4762)."""
    head_height: float
    """Height of a socket head."""
    sunk: float
    """Diameter of a countersunk head (ISO 10642)."""
    flats: float
    """Width of a nut across its flats (ISO 4032)."""
    nut: float
    """Largest height of a nut."""
    key: float
    """Hexagon key of a socket head (ISO 4762)."""
    key_sunk: float
    """Hexagon key of a countersunk head (ISO 10642)."""
    torque: float
    """Torque into plastic or onto it [N m] (ours: hand-tight with the short end of the key)."""


THREADS = {
    "M3": Thread(name="M3", shaft=3.0, head=5.5, head_height=3.0, sunk=5.5, flats=5.5, nut=2.4, key=2.5, key_sunk=2.0,
                 torque=0.5),
    "M4": Thread(name="M4", shaft=4.0, head=7.0, head_height=4.0, sunk=7.5, flats=7.0, nut=3.2, key=3.0, key_sunk=2.5,
                 torque=1.0),
    "M6": Thread(name="M6", shaft=6.0, head=10.0, head_height=6.0, sunk=11.1, flats=10.0, nut=5.2, key=5.0,
                 key_sunk=4.0, torque=2.5),
}  # fmt: skip
"""Sizes in use."""


@final
@dataclass(frozen=True, kw_only=True)
class Bolt:
    """One screw in the assembled robot."""

    what: str
    """Purpose: what it joins."""
    parts: tuple[str, ...]
    """Names of the parts that it passes or enters."""
    thread: Thread
    """Size."""
    seat: tuple[float, float, float]
    """Point of its axis in the plane under its head; of a countersunk head, in the plane flush with it."""
    along: tuple[float, float, float]
    """Unit vector from head to end."""
    length: float
    """Length below that plane."""
    is_sunk: bool = False
    """Whether its head is countersunk."""
    nut_at: float | None = None
    """Distance from the seat to the near face of its nut; None for an insert, a thread or a motor."""
    is_nut_trapped: bool = False
    """Whether the nut lies in a hexagonal pocket."""
    is_head_elsewhere: bool = False
    """Whether the head lies on a part that is not checked."""
    way: float = 0.0
    """Length of the straight path of a key to the head during assembly."""

    def forms(self) -> tuple[Form, ...]:
        """Volumes of head, shaft and nut."""
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
        """Volume of the key's path to the head; None without one."""
        if not self.way:
            return None
        top = np.array(self.seat) - (0.0 if self.is_sunk else self.thread.head_height) * np.array(self.along)
        return rod(self.thread.head / 2, top - self.way * np.array(self.along), top)


def pick_length(most: float) -> float | None:
    """Longest standard length up to ``most``; None where there is none."""
    return max((length for length in LENGTHS if length <= most), default=None)


def sink(thread: Thread, hole: float, extra: float = 0.3) -> Form:
    """Countersink of 90 deg, from below z = 0 up."""
    wide = thread.sunk / 2 + extra
    deep = wide - hole / 2 + 0.1
    return Revolved(profile=((0.0, -0.5), (wide, -0.5), (wide, 0.0), (hole / 2 - 0.1, deep), (0.0, deep)))


def hexagon(flats: float, place: Sequence[float], top: float) -> Form:
    """Hexagonal pocket for a nut, from its floor at ``place`` to ``top``, one flat towards the axis."""
    x, y, z = place
    corner, first = flats / math.sqrt(3), math.atan2(y, x) + math.pi / 6
    turns = [first + k * math.pi / 3 for k in range(6)]
    return Prism(
        corners=tuple((x + corner * math.cos(turn), y + corner * math.sin(turn)) for turn in turns), bottom=z, top=top
    )
