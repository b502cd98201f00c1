"""Box for the electronics beside the arm: least inner size and the glands that hold its leads.

Sizes of the items are ours, of usual ones; measure what you bought. Nothing was built.
"""

from __future__ import annotations

from typing import NamedTuple, final

from spiraltrunk.cad.output.purchase import Purchase

POWER = 350.0
"""Largest power of a supply of the size `SUPPLY` [W] (ours)."""

SUPPLY = (215.0, 115.0, 30.0)
"""Enclosed 24 V supply of `POWER`: length, width, height [mm] (ours, as usual supplies of this power measure)."""

BESIDE = {
    "relay in its socket": (60.0, 30.0, 75.0),
    "fuse block": (90.0, 60.0, 45.0),
    "USB-CAN adapter or board": (70.0, 45.0, 25.0),
    "capacitor": (40.0, 25.0, 25.0),
}
"""What stands beside the supply: length, width, height [mm] (ours)."""

BESIDE_SERVO = {"step-down converter": (65.0, 40.0, 25.0), "servo driver": (50.0, 35.0, 20.0)}
"""The same with a gripper."""

GAP = 15.0
"""Air between two items, for their wires [mm] (ours)."""

BEND = 40.0
"""Room at the wall with the glands, in which leads are bent [mm] (ours)."""


@final
class InnerSize(NamedTuple):
    """Inside of a box [mm]."""

    length: float
    """Along the supply, with the glands at one end."""
    width: float
    """Across it."""
    height: float
    """From the floor to the lid."""


def size_enclosure(*, has_servo: bool) -> InnerSize:
    """Least inside of a box: the other items stand in a row or two beside the supply, with `GAP` round each."""
    items = list((BESIDE | (BESIDE_SERVO if has_servo else {})).values())
    length = SUPPLY[0] + 2 * GAP
    rows, filled = [0.0], 0.0
    for long, wide, _ in sorted(items, key=lambda item: -item[1]):
        if filled + long + GAP > length - GAP:
            rows.append(0.0)
            filled = 0.0
        filled += long + GAP
        rows[-1] = max(rows[-1], wide)
    width = SUPPLY[1] + 2 * GAP + sum(row + GAP for row in rows)
    return InnerSize(length + BEND, width, max(item[2] for item in (*items, SUPPLY)) + GAP)


def count_glands(n_cable: int, *, has_servo: bool) -> int:
    """Leads: each motor's supply, bus, mains, emergency stop and USB; with a servo its lead and its driver's USB."""
    return n_cable + 4 + 2 * has_servo


def list_enclosure(n_cable: int, place: str, *, power: float, has_servo: bool) -> list[Purchase]:
    """The box and its glands, for a supply of this power [W]."""
    inner, (long, wide, tall) = size_enclosure(has_servo=has_servo), SUPPLY
    larger = (
        f"the supply of {power:.0f} W is larger than the {long:g} x {wide:g} x {tall:g} mm counted here: add what it "
        "measures more; "
    ) * (power > POWER)
    rows = (
        (1, "enclosure with lid and knock-outs, vented",
         f"inside {inner.length:.0f} x {inner.width:.0f} x {inner.height:.0f} mm or more",
         f"flame retardant plastic or earthed metal; {larger}measure the bought electronics first; vents or a fan by "
         "the supply's manual"),
        (count_glands(n_cable, has_servo=has_servo), "cable gland with nut", "M16, for leads of 4 to 10 mm",
         "strain relief: one for each lead through the wall"),
    )  # fmt: skip
    return [
        Purchase(kind="electronics", item=item, count=count, size=size, place=place, note=note)
        for count, item, size, note in rows
    ]
