"""What is bought fits what is made: screws have room, seats and a way for the key, and the check notices where not."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from spiraltrunk.cad.checks.assembly import build_motors, check_hardware, find_faults, list_bolts
from spiraltrunk.cad.components.fasteners import LENGTHS, THREADS, Bolt, pick_length
from spiraltrunk.cad.geometry.csg import Cut, box, compute_bounds, contains, rod
from spiraltrunk.cad.geometry.part import Part
from spiraltrunk.cad.housing.layout import find_layout
from spiraltrunk.cad.housing.winder import find_drum, motor_angles, motor_ring
from spiraltrunk.cad.output.cable_lengths import cable_length
from spiraltrunk.cad.output.catalogue import build_parts
from spiraltrunk.cad.output.purchases import group_bolts
from spiraltrunk.cad.trunk.body import build_body
from spiraltrunk.cad.trunk.neck_screws import find_neck_screw
from spiraltrunk.cad.trunk.pieces import plan_planes
from spiraltrunk.cad.trunk.pins import find_pins
from spiraltrunk.design import presets
from spiraltrunk.design.materials import PETG
from spiraltrunk.errors import PartError

FAST = {"paper", "spirob-15"}
"""The trunk of the paper and the smallest one."""

GROUPS = ("trunk", "housing", "adapter", "wedge")

NAMES = pytest.mark.parametrize(
    "name", [name if name in FAST else pytest.param(name, marks=pytest.mark.slow) for name in presets.NAMES]
)


@NAMES
def test_every_screw_of_a_preset_fits(name, options):
    design = presets.get(name)
    assert check_hardware(design, options, build_parts(design, GROUPS, options)) >= 26


@NAMES
def test_no_two_parts_are_in_one_place(name, options):
    """Points of each part of the assembled robot, one drum for all, lie in no other part and in no motor."""
    design, random = presets.get(name), np.random.default_rng(0)
    groups = ("trunk", "gripper", "housing", "drums", "adapter")
    parts = build_parts(design, groups, options)
    motors = [body for what, body in build_motors(design, options) if what == "motor"]
    for part in parts:
        low, high = compute_bounds(part.form)
        own = low + (high - low) * random.random((8000, 3))
        own = own[contains(part.form, own)]
        c, s = math.cos(part.turn), math.sin(part.turn)
        placed = own @ np.array([[1, 0, 0], [0, c, s], [0, -s, c]]) + part.at
        np.testing.assert_allclose(part.to_own_frame(placed), own, atol=1e-9)
        for other in parts:
            assert other is part or not contains(other.form, other.to_own_frame(placed)).any(), (part.name, other.name)
        assert not any(contains(body, placed).any() for body in motors), part.name


def test_a_screw_in_the_way_is_told(options):
    """The same screws against parts that are shifted: by half a millimetre nothing fits any more."""
    parts = build_parts(presets.PAPER, GROUPS, options)
    moved = [replace(part, at=(part.at[0] + 0.5 * (part.name == "lid"), *part.at[1:])) for part in parts]
    with pytest.raises(PartError, match=r"screw M[34] x \d+ at .* is in the material of part lid"):
        check_hardware(presets.PAPER, options, moved)


def plate(hole: float = 4.5) -> Part:
    form = Cut(form=box((30, 30, 5), (0, 0, 2.5)), tools=(rod(hole / 2, (0, 0, -1), (0, 0, 6)),))
    return Part(name="plate", group="plate", what="a plate", material=PETG, form=form)


def bolt(**changes) -> Bolt:
    return replace(
        Bolt(what="plate to air", parts=("plate",), thread=THREADS["M4"], seat=(0.0, 0.0, 5.0), along=(0.0, 0.0, -1.0),
             length=12.0, nut_at=5.0, way=20.0), **changes,
    )  # fmt: skip


@pytest.mark.parametrize(
    ("screw", "fault"),
    [
        (bolt(), ""),
        (bolt(seat=(0.0, 0.0, 4.0)), "is in the material of part plate"),
        (bolt(seat=(0.0, 0.0, 8.0), length=16.0, nut_at=8.0), "no material under 12 of 12 points of its head"),
        (bolt(nut_at=6.0), "no material under 12 of 12 points of its nut"),
        (bolt(seat=(14.0, 0.0, 5.0)), "is in the material"),
        (bolt(seat=(0.0, 0.0, 0.0), along=(0.0, 0.0, 1.0), way=20.0), ""),
    ],
)
def test_room_and_seats(screw, fault):
    found = find_faults([screw], [plate()], [])
    assert (not found) == (not fault)
    assert any(fault in one for one in found) or not fault


def test_a_head_needs_more_than_its_hole():
    """A hole as wide as the head leaves nothing to sit on."""
    assert any("under 12 of 12" in fault for fault in find_faults([bolt()], [plate(hole=7.2)], []))


def test_a_key_must_come_to_the_head():
    above = box((30, 30, 5), (0, 0, 22))
    part = plate()
    lid = Part(name="roof", group="plate", what="a roof", material=PETG, form=above)
    screw = bolt(parts=("plate", "roof"))
    assert find_faults([screw], [part, lid], []) == [
        "plate to air: screw M4 x 12 at (0.0, 0.0, 5.0) mm cannot be reached by a key for roof"
    ]
    assert find_faults([bolt(parts=("plate", "roof"), way=8.0)], [part, lid], []) == []


def test_two_screws_in_one_place_are_told():
    assert any("is in the place of" in fault for fault in find_faults([bolt(), bolt()], [plate()], []))


@pytest.mark.parametrize("name", presets.NAMES)
def test_nothing_stands_in_the_first_gap(name):
    """Screw and nut end below section 1's distal face, so that the joint can shut."""
    design, screw = presets.get(name), find_neck_screw(presets.get(name))
    corner = screw.ring + THREADS["M4"].flats / math.sqrt(3)
    face = 1e3 * design.solid.length - corner * math.tan(design.solid.lean_distal)
    assert screw.seat + screw.length <= face
    assert screw.nut + THREADS["M4"].nut < screw.seat + screw.length
    assert screw.length in LENGTHS


@pytest.mark.parametrize("tall", [100.0, 180.0, 210.0, 256.0])
def test_pins_stay_inside_their_section(tall, options):
    """Points of each hole, with a wall round it, lie in the piece's outline on both sides of the cut."""
    design, options = presets.PAPER, replace(options, bed=(256.0, 256.0, tall))
    body = build_body(design, options)
    planes = plan_planes(design, body, options)
    pins = find_pins(design, body, planes, options)
    assert len(pins) == len(planes) - 2
    for pin in pins:
        n = int(np.searchsorted(body.starts, pin.height)) - 1
        scale = 1e3 * design.scale[n]
        near = body.starts[n] + (pin.ring + pin.diameter / 2) * math.tan(design.solid.lean_proximal)
        far = body.starts[n] + scale * design.solid.length - pin.ring * math.tan(design.solid.lean_distal)
        assert pin.height - pin.depth - options.least_wall >= near
        assert pin.height + pin.depth + options.least_wall <= far
        assert pin.depth >= 3


@pytest.mark.parametrize("name", presets.NAMES)
def test_a_cable_comes_level_from_its_guide_to_its_drum(name, options):
    """The guide ends at the middle of the groove, and clear of drum and motor."""
    design = presets.get(name)
    lid = next(part for part in build_parts(design, ["housing"], options) if part.name == "lid")
    room, drum = find_layout(design, options), find_drum(design, options)
    level = lid.at[2] - options.plate - room.height + room.groove
    ring = 1e3 * float(design.hole_position[0, 0, 1])
    for cable in design.cable.angles:
        around = [(ring * math.cos(cable) + 4.5 * math.cos(a), ring * math.sin(cable) + 4.5 * math.sin(a))
                  for a in np.linspace(0, 2 * math.pi, 12)]  # fmt: skip
        for above, is_guide in ((0.3, True), (-0.3, False)):
            points = np.array([(x, y, level + above) for x, y in around])
            assert contains(lid.form, lid.to_own_frame(points)).all() == is_guide
    axis = np.array([motor_ring(design, options), motor_angles(design)[0]])
    apart = math.dist(
        (ring * math.cos(design.cable.angles[0]), ring * math.sin(design.cable.angles[0])),
        (axis[0] * math.cos(axis[1]), axis[0] * math.sin(axis[1])),
    )
    assert apart > drum.flange + 7.0
    assert cable_length(design, options) > 1e3 * (design.length + design.housing.neck_length + design.cable_stroke)


def test_the_longest_that_fits():
    assert pick_length(46.3) == 45.0
    assert pick_length(5.9) is None


def test_the_bill_counts_every_screw(options):
    """By what they join: as many as there are places for them."""
    names = {"adapter", "housing", "lid", "neck", "trunk_1"}
    bolts = list_bolts(presets.PAPER, options, names)
    counted = {(row.place, row.item.split()[0], row.size): row.count for row in group_bolts(bolts)}
    assert counted == {
        ("adapter to the arm's flange", "socket", "M6 x 12"): 4,
        ("housing to adapter", "socket", "M4 x 12"): 3,
        ("inserts of the adapter", "heat-set", "M4"): 3,
        ("motor to housing", "countersunk", "M4 x 10"): 12,
        ("lid to housing", "countersunk", "M3 x 10"): 3,
        ("inserts of the housing", "heat-set", "M3"): 3,
        ("neck to lid", "socket", "M4 x 16"): 6,
        ("neck to lid", "nut", "M4"): 6,
        ("neck to section 1", "socket", "M4 x 45"): 3,
        ("neck to section 1", "nut", "M4"): 3,
    }
