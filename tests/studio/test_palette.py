"""Colours that are told apart by meaning stay apart in any colour vision, and letters can be read on their ground."""

from itertools import combinations

import numpy as np
import pytest

pytest.importorskip("viser", reason="viser is not installed")

from spiraltrunk.report.style import COLORS
from spiraltrunk.studio.design.picture import _LINES, _PARTS, CABLE
from spiraltrunk.studio.drawing.trunk_view import BODY, GHOST, linear_color
from spiraltrunk.studio.grasp.stage_view import STRING_COLOR
from spiraltrunk.studio.measure.error_scale import GAP, color_distances
from spiraltrunk.studio.measure.picture import MEASURED
from spiraltrunk.studio.measure.texts import RMSE
from spiraltrunk.studio.page.page import _COLORS
from spiraltrunk.studio.page.theme import BRAND
from spiraltrunk.studio.robot.texts import _BADGES
from spiraltrunk.studio.shape.picture import MISSED, SHUT

VISIONS = {
    "normal": np.eye(3),
    "protanopia": np.array(
        [(0.152286, 1.052583, -0.204868), (0.114503, 0.786281, 0.099216), (-0.003882, -0.048116, 1.051998)]
    ),
    "deuteranopia": np.array(
        [(0.367322, 0.860646, -0.227968), (0.280085, 0.672501, 0.047413), (-0.011820, 0.042940, 0.968881)]
    ),
    "tritanopia": np.array(
        [(1.255528, -0.076749, -0.178779), (-0.078411, 0.930809, 0.147602), (0.004733, 0.691367, 0.303900)]
    ),
}
"""What is seen of linear RGB, at severity 1 (Machado, Oliveira and Fernandes 2009, table 1)."""

LEAST_DIFFERENCE = 15.0
"""Least distance of two colours in CIELAB; 2.3 is just noticed side by side [-]."""

SETS = {
    "cables of the paper's trunk": COLORS[:3],
    "legend of Design": (CABLE, *(color for name, color in _LINES.items() if name != "sections")),
    "legend of Shape": (SHUT, BODY, GHOST),
    "trunk and the missed place": (BODY, SHUT, MISSED),
    "lines of Measure": (RMSE, MEASURED),
    "overlay of Measure": (MEASURED, GAP),
    "notices": tuple(dict.fromkeys(_COLORS.values())),
    "states of the robot": tuple(_BADGES[name][0] for name in ("safe", "homing", "armed", "fault")),
    "string and body": (STRING_COLOR, BODY),
}
"""Colours that a person has to tell apart, by what shows them."""


def read(color):
    """Linear RGB of a colour, "#rrggbb" or three numbers from 0 to 255."""
    if isinstance(color, str):
        color = {"white": "#ffffff", "black": "#000000"}.get(color, color)
        color = [int(color[i : i + 2], 16) for i in (1, 3, 5)]
    share = np.array(color, float) / 255
    return np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4)


def find_place(color, vision):
    """Place in CIELAB of a colour as that vision sees it."""
    seen = np.clip(VISIONS[vision] @ read(color), 0, 1)
    to_xyz = np.array(
        [(0.4124564, 0.3575761, 0.1804375), (0.2126729, 0.7151522, 0.0721750), (0.0193339, 0.1191920, 0.9503041)]
    )
    xyz = to_xyz @ seen / (to_xyz @ np.ones(3))
    x, y, z = np.where(xyz > 216 / 24389, np.cbrt(xyz), (24389 / 27 * xyz + 16) / 116)
    return np.array((116 * y - 16, 500 * (x - y), 200 * (y - z)))


def compute_contrast(one, other):
    """Contrast of two colours, 1 to 21 (Web Content Accessibility Guidelines 2.1)."""
    weights = (0.2126, 0.7152, 0.0722)
    low, high = sorted((float(read(one) @ weights), float(read(other) @ weights)))
    return (high + 0.05) / (low + 0.05)


@pytest.mark.parametrize("vision", VISIONS)
@pytest.mark.parametrize("name", SETS)
def test_colours_that_mean_different_things_look_different(name, vision):
    places = [find_place(color, vision) for color in SETS[name]]
    least = min(np.linalg.norm(one - other) for one, other in combinations(places, 2))
    assert least > LEAST_DIFFERENCE


@pytest.mark.parametrize("vision", VISIONS)
def test_cables_of_a_design_differ_from_its_lines_and_sections(vision):
    cable = find_place(CABLE, vision)
    others = (*_LINES.values(), *(_PARTS[name] for name in ("odd", "even", "joints", "gripper")))
    assert min(np.linalg.norm(cable - find_place(other, vision)) for other in others) > 2 * LEAST_DIFFERENCE


def test_cables_of_a_design_are_seen_on_light_and_dark_ground():
    assert compute_contrast(CABLE, "white") > 4.5
    assert compute_contrast(CABLE, "#141414") > 3


@pytest.mark.parametrize("vision", VISIONS)
def test_a_larger_error_is_lighter(vision):
    scale = color_distances(np.linspace(0, 1, 21), 1.0)
    lightness = [find_place(color, vision)[0] for color in scale]
    assert (np.diff(lightness) > 1.0).all()


def test_the_measure_itself_fails_for_red_and_green():
    red, green = (find_place(color, "deuteranopia") for color in ("#b35a00", "#7d7a00"))
    assert np.linalg.norm(red - green) < LEAST_DIFFERENCE
    assert compute_contrast("#ffffff", "#000000") == pytest.approx(21)


@pytest.mark.parametrize("name", _BADGES)
def test_letters_of_states_are_readable(name):
    assert compute_contrast(*_BADGES[name]) > 4.5


def test_letters_on_buttons_and_labels_are_readable():
    assert compute_contrast(BRAND, "white") > 4.5
    assert compute_contrast((200, 0, 0), "white") > 4.5
    assert compute_contrast("#5b6168", "white") > 6
    assert compute_contrast("#adb1b6", "#242424") > 6


class LinesTab:
    """Two lines across the scene, coloured in the two ways that there are."""

    name = title = "lines"

    def __init__(self, page):
        self._page = page

    def build(self):
        one = np.array([[[-5.0, 0.0, 0.0], [5.0, 0.0, 0.0]]])
        each = np.tile(np.array(linear_color(MEASURED), np.uint8), (1, 2, 1))
        for height, colors in ((-0.4, MEASURED), (0.4, each)):
            self._page.scene.add_line_segments(
                f"/lines/{height}", one, colors, thickness=20.0, thickness_units="screen", position=(0.0, 0.0, height)
            )

    def show(self):
        camera = self._page.client.camera
        camera.position, camera.look_at = (0.0, -3.0, 0.0), (0.0, 0.0, 0.0)

    def hide(self):
        pass

    def read_settings(self):
        return {}

    def apply_settings(self, settings):
        pass

    def close(self):
        pass


@pytest.mark.slow
def test_lines_have_their_colour_on_the_page(studio, open_page, take_picture):
    page = open_page(studio([LinesTab]))
    for _ in range(40):
        page.wait_for_timeout(250)
        column = take_picture(page, "lines")[:, 430]
        drawn = column[column.min(axis=1) < 200]
        if len(drawn) >= 30:  # Both lines, 20 pixels each.
            break
    assert 30 <= len(drawn) <= 44
    assert (np.abs(drawn - MEASURED).max(axis=1) < 16).mean() > 0.85
