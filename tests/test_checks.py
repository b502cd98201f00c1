"""Every field of every design dataclass refuses what it cannot be, and the error names the field."""

import importlib
import math
import pkgutil
import re
from dataclasses import fields, is_dataclass, replace

import numpy as np
import pytest

import spiraltrunk.design
from spiraltrunk.design import (
    ArmDesign,
    CableDesign,
    GripperDesign,
    HousingDesign,
    JointDesign,
    MassDesign,
    SectionSolid,
    Spiral,
    TrunkDesign,
)
from spiraltrunk.design.drum import DrumDesign, DrumOptions, size_drum
from spiraltrunk.design.presets import PAPER
from spiraltrunk.design.strand_route import StrandRoute
from spiraltrunk.errors import DesignError

GOOD = {
    Spiral: PAPER.spiral,
    SectionSolid: PAPER.solid,
    JointDesign: JointDesign(radius=1e-3, length=1e-3, stiffness=(1.0, 2.0)),
    CableDesign: PAPER.cable,
    MassDesign: PAPER.mass,
    GripperDesign: PAPER.gripper,
    HousingDesign: replace(PAPER.housing, mass=1.85, neck_mass=0.06),
    ArmDesign: ArmDesign(home=(0.0, 1.0)),
    TrunkDesign: PAPER,
    DrumOptions: DrumOptions(),
    DrumDesign: size_drum(PAPER),
    StrandRoute: StrandRoute(first_solid=11, aside=0.002),
}
"""One valid value of each dataclass."""

OUT_OF_RANGE = {
    DrumOptions: {
        "cable_diameter": (0.0, -1e-3, 1.0),
        "motor_diameter": (0.0, -1e-3, 1.0),
        "motor_clearance": (-1e-9, 1.0),
        "rotor_circle": (0.0, -1e-3, 1.0),
        "torque_max": (0.0, -1.0, 1e4),
    },
    DrumDesign: {
        "winding_radius": (0.0, -1e-2, 1.0),
        "cable_diameter": (0.0, -1e-3, 0.1),
        "width": (0.0, -1e-3, 1.0),
        "travel_in": (0.0, -0.1, 100.0),
        "travel_out": (-1e-9, 100.0),
        "dead_turns": (-1e-9, 100.0),
    },
    Spiral: {"a": (0.0, -1e-3, 1e3), "b": (0.0, -0.16, 2.0)},
    SectionSolid: {
        "length": (0.0, -1.0),
        "radius": (0.0, -1.0, 0.2),
        "lean_proximal": (-math.pi / 2, math.pi / 2, 1e300),
        "lean_distal": (-math.pi / 2, math.pi / 2, -1e300),
    },
    JointDesign: {
        "radius": (0.0, -1e-3, 1.0),
        "length": (0.0, -1e-3, 1.0),
        "youngs_modulus": (0.0, -1.0, 1e12),
        "damping_time": (-1e-9, 10.0),
        "stiffness": ((0.0, 1.0), (1.0, -1.0)),
    },
    CableDesign: {
        "angles": ((), (0.0,), (0.0, 0.01), (0.0, 2 * math.pi), tuple(range(13))),
        "hole_fraction": (0.0, 1.0, -0.6),
        "tension_max": (0.0, -1.0, 1e4),
        "friction": (-1e-9, 2.0, 1e300),
    },
    MassDesign: {
        "density": (0.0, -1.0, 3e4),
        "sections": ((0.0,), (-1.0,)),
        "center_fraction": (0.0, 1.0, -0.5),
    },
    GripperDesign: {
        "n_finger": (1, 9, -3, 3.0),
        "b": (0.0, 2.0, -1.0),
        "delta_theta": (0.0, math.pi / 2, -1.0),
        "n_phalanx": (0, 9, 2.0),
        "finger_length": (0.0, -1.0, 10.0),
        "finger_width": (0.0, -1.0, 10.0),
        "mount_radius": (-1e-9, 10.0),
        "mass": (0.0, -1.0, 1e6),
        "stiffness": (0.0, -1.0, 1e6),
        "tension_max": (0.0, -1.0, 1e4),
        "n_leg": (0, 3, 1.5),
    },
    StrandRoute: {"first_solid": (-1, 1001, 1.5), "aside": (-1e-9, 1.0)},
    HousingDesign: {
        "radius": (0.0, -1.0, 1.0),
        "length": (0.0, -1.0, 1.0),
        "material": ("", "petg", "TPU 95A"),
        "mass": (0.0, -1.0, 100.0),
        "neck_length": (0.0, -1.0, 1.0),
        "neck_mass": (0.0, -1.0, 100.0),
    },
    ArmDesign: {
        "model": ("", "two\nlines", "x" * 1001),
        "mount_site": ("", "tab\t", "x" * 201),
        "base_height": (-1e-9, 10.0),
        "roll": (-10.0, 10.0),
        "home": ((), (0.0,) * 33),
    },
    TrunkDesign: {
        "name": ("", "two\nlines", "x" * 201),
        "spiral": (PAPER.joint,),
        "k": (0.0, 1.0, -0.5, math.exp(-2 * math.pi * 0.16)),
        "delta_theta": (0.0, math.pi / 2, -1.0),
        "n_section": (1, 0, -18, 201, 18.0),
        "theta_tip": (-100.0, 100.0),
        "joint": (PAPER.spiral, None, JointDesign),
        "cable": (PAPER.mass, None),
        "mass": (PAPER.cable, None),
        "gripper": (PAPER.arm,),
        "housing": (PAPER.arm, None),
        "arm": (PAPER.housing, None),
    },
}
"""Values of the right type that no design can have."""

NEVER = [
    math.nan,
    math.inf,
    -math.inf,
    1j,
    [],
    {},
    b"1",
    np.ones(3),
    object(),
]
"""Values that no field takes."""

FIELDS = [(cls, field.name) for cls in GOOD for field in fields(cls)]


def refusal(cls, field, value):
    """The name in the error of ``cls`` with ``field`` set to ``value``."""
    with pytest.raises(DesignError) as caught:
        replace(GOOD[cls], **{field: value})
    assert "\n" not in str(caught.value)
    assert "allowed: " in str(caught.value)
    return re.split(r"[.\[]", caught.value.name)


def test_no_dataclass_and_no_field_is_left_out():
    found = set()
    for module in pkgutil.iter_modules(spiraltrunk.design.__path__, "spiraltrunk.design."):
        loaded = importlib.import_module(module.name)
        own = [item for item in vars(loaded).values() if isinstance(item, type) and item.__module__ == module.name]
        found |= {item for item in own if is_dataclass(item)}
    assert found == set(GOOD) == set(OUT_OF_RANGE)
    for cls, ranges in OUT_OF_RANGE.items():
        assert list(ranges) == [field.name for field in fields(cls)]


@pytest.mark.parametrize(("cls", "field"), FIELDS)
def test_every_field_refuses_what_is_never_a_value(cls, field):
    for value in NEVER:
        assert field in refusal(cls, field, value)


@pytest.mark.parametrize(("cls", "field"), FIELDS)
def test_every_field_refuses_values_out_of_range(cls, field):
    for value in OUT_OF_RANGE[cls][field]:
        assert field in refusal(cls, field, value)


@pytest.mark.parametrize(("cls", "field"), FIELDS)
def test_every_field_refuses_text_for_numbers_and_numbers_for_text(cls, field):
    is_text = isinstance(getattr(GOOD[cls], field), str)
    assert field in refusal(cls, field, 1.0 if is_text else "1.0")


@pytest.mark.parametrize(("cls", "field"), FIELDS)
def test_none_is_refused_where_it_says_nothing(cls, field):
    optional = {(JointDesign, "stiffness"), (MassDesign, "sections"), (MassDesign, "center_fraction"),
                (ArmDesign, "home"), (TrunkDesign, "gripper"), (HousingDesign, "mass"),
                (HousingDesign, "neck_mass")}  # fmt: skip
    if (cls, field) in optional:
        assert getattr(replace(GOOD[cls], **{field: None}), field) is None
    else:
        assert field in refusal(cls, field, None)


@pytest.mark.parametrize(("cls", "field"), [(c, f) for c, f in FIELDS if isinstance(getattr(GOOD[c], f), tuple)])
@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf, "1", None, (1.0,)])
def test_every_number_of_a_tuple_is_checked_by_its_place(cls, field, bad):
    good = getattr(GOOD[cls], field)
    assert refusal(cls, field, (*good[:-1], bad))[-2:] == [field, f"{len(good) - 1}]"]


def test_whole_numbers_and_numpy_floats_are_numbers():
    assert Spiral(a=1, b=np.float64(0.16)).a == 1
    assert Spiral(a=2, b=1) == Spiral(a=2.0, b=1.0)


def test_the_message_says_given_and_allowed():
    with pytest.raises(DesignError, match=re.escape("spiral.b is -0.16; allowed: a finite number, above 0, below 2")):
        Spiral(a=1.0, b=-0.16)
    with pytest.raises(DesignError, match=r"joint\.damping_time is -1; allowed: a finite number, at least 0, below 10"):
        JointDesign(radius=1e-3, length=1e-3, damping_time=-1)
