"""Adapter, double arm and housing: what goes into them has room, and the picture shows all of it."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from xml.etree import ElementTree as ET

import numpy as np
import pytest

from spiraltrunk.cad.components.options import ADAPTER, Flange
from spiraltrunk.cad.geometry.csg import contains, polar
from spiraltrunk.cad.housing.housing import build_adapter
from spiraltrunk.cad.housing.layout import find_layout
from spiraltrunk.cad.housing.winder import build_horn, find_arm
from spiraltrunk.cad.output.top_view import format_top_view
from spiraltrunk.design import presets
from spiraltrunk.errors import DesignError

MESSAGE = re.compile(r"part housing: housing\.radius_mm is ([\d.]+) mm; allowed: at least ([\d.]+) mm: (.*)")
MOTORS, SCREWS = "3 motors of 66.7 mm side by side", "screws beside the motors"


def rim(place: tuple[float, float], radius: float, height: float) -> np.ndarray:
    """Points on a level circle about a place, shape (24, 3) [mm]."""
    angle = np.linspace(0.0, 2 * math.pi, 24, endpoint=False)
    around = np.stack([np.cos(angle), np.sin(angle), np.zeros(24)], axis=-1)
    return np.array([*place, height]) + radius * around


def test_the_flanges_dowel_enters_the_adapter(options):
    """With play all around, and no deeper than the screws' heads leave room for."""
    form, flange = build_adapter(presets.PAPER, options)[0].form, options.flange
    x, y, _ = polar(flange.pitch_circle / 2, 0.0, 0.0)
    for height in (ADAPTER - 5.9, ADAPTER - 0.1):
        assert not contains(form, rim((x, y), flange.dowel / 2 + 0.03, height)).any()
        assert contains(form, rim((x, y), flange.dowel / 2 + 0.2, height)).all()
    assert contains(form, rim((x, y), flange.dowel / 2, 1.0)).all()


@pytest.mark.parametrize("nozzle", [0.4, 0.8])
def test_the_double_arm_is_the_same_turned_by_half(nozzle, options):
    """A cable of each group at either end, with two walls on both sides of its hole."""
    options = replace(options, nozzle=nozzle)
    form, arm = build_horn(presets.PAPER, options)[0].form, find_arm(presets.PAPER, options)
    box = np.array([arm + 8.0, options.servo.hub_diameter, 3.0])
    points = np.random.default_rng(0).uniform(-1.0, 1.0, (40_000, 3)) * box
    is_inside = contains(form, points)
    assert 0.1 < is_inside.mean() < 0.9
    assert (is_inside == contains(form, points * [-1.0, -1.0, 1.0])).all()
    for x in (arm, -arm):
        assert not contains(form, np.array([[x, 0.0, 1.5]])).any()
        beside = options.hole / 2 + 2 * options.wall - 0.01
        assert contains(form, np.array([[x, y, 1.5] for y in (beside, -beside)])).all()


@pytest.mark.parametrize(
    ("outer", "reasons"), [(63.0, [MOTORS]), (90.0, [MOTORS]), (130.0, [MOTORS, SCREWS]), (250.0, [MOTORS, SCREWS])]
)
def test_the_radius_that_is_asked_for_is_enough(outer, reasons, options):
    """For motors side by side, then for screws outside the flange; each error tells the radius that was given."""
    options, radius, told = replace(options, flange=Flange(outer=outer)), 50.0, []
    for _ in range(4):
        try:
            find_layout(replace(presets.PAPER, housing=replace(presets.PAPER.housing, radius=1e-3 * radius)), options)
            break
        except DesignError as error:
            given, allowed, why = MESSAGE.fullmatch(str(error)).groups()
        told.append((why, radius - float(given)))
        radius = float(allowed) + 0.01
    assert told == [(why, pytest.approx(0.0, abs=0.01)) for why in reasons]


@pytest.mark.parametrize("name", presets.NAMES)
def test_the_picture_shows_all_and_its_captions_stand_below(name, options):
    root = ET.fromstring(format_top_view(presets.get(name), options))
    left, top, width, height = (float(value) for value in root.attrib["viewBox"].split())
    circles = [[float(one.attrib[key]) for key in ("cx", "cy", "r")] for one in root.iter() if "cx" in one.attrib]
    for x, y, r in circles:
        assert left + r < x < left + width - r
        assert top + r < y < top + height - r
    words = {
        one.text: (float(one.attrib["x"]), float(one.attrib["y"]))
        for one in root.iter()
        if "fill" in one.attrib and one.text
    }
    assert all(left < x < left + width and top < y < top + height for x, y in words.values())
    captions = [y for text, (_, y) in words.items() if ":" in text]
    size = float(root.attrib["font-size"])
    assert len(captions) == 2
    assert min(captions) - size > max(y + r for _, y, r in circles)
    assert abs(captions[1] - captions[0]) > size
