"""The trunk as two degrees of freedom against the trunk's own model."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from spiraltrunk.design import presets
from spiraltrunk.design.presets import PAPER
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import DriveError
from spiraltrunk.hardware.twin.trunk.spring_trunk import SpringTrunk
from spiraltrunk.hardware.twin.trunk.trunk_curl import compute_curl
from spiraltrunk.model import statics
from spiraltrunk.model.kinematics.cables import lengths

BARE = replace(PAPER, gripper=None)
STIFF = [2e4] * 3


def hold(trunk: SpringTrunk, tensions: Sequence[float], duration: float = 4.0) -> np.ndarray:
    """What is taken up of each cable at rest under these tensions, by springs soft enough to keep them [m]."""
    soft = 1e-2
    for _ in range(round(duration / 1e-3)):
        wound = [pull / soft + taken for pull, taken in zip(tensions, trunk.taken, strict=True)]
        trunk.advance(wound, [soft] * 3, 1e-3)
    return np.array(trunk.taken)


@pytest.mark.parametrize("tensions", [(2, 0, 0), (5, 0, 0), (10, 0, 0), (20, 0, 0), (30, 0, 0), (5, 5, 0), (0, 0, 20)])
def test_hanging_it_gives_way_as_the_papers_trunk(tensions: tuple[float, ...]) -> None:
    """Static equilibrium of the whole trunk, to 4 mm of its 130 mm: 30 N pull 129 mm, and the others pay 58 mm out."""
    expected = statics.solve(BARE, tension=tensions).cable_change
    assert hold(SpringTrunk(BARE), tensions) == pytest.approx(expected, abs=4e-3)


@pytest.mark.parametrize("name", ["spirob-15", "spirob-1m"])
@pytest.mark.parametrize("tension", [2.0, 10.0, 30.0])
def test_other_designs_give_way_as_their_models_do(name: str, tension: float) -> None:
    """To 3 % of the stroke."""
    design = presets.get(name)
    pulls = (tension,) + (0.0,) * (design.n_cable - 1)
    expected = statics.solve(design, tension=pulls).cable_change
    assert hold(SpringTrunk(design), pulls) == pytest.approx(expected, abs=0.03 * design.cable_stroke)


@pytest.mark.parametrize("tensions", [(0, 0, 0), (2, 0, 0), (10, 0, 0), (30, 0, 0), (0, 0, 20)])
def test_held_level_it_sags_about_as_the_papers_trunk(tensions: tuple[float, ...]) -> None:
    """One shape for each curl is stiffer than the trunk in one place and softer in another: to 10 mm."""
    expected = statics.solve(BARE, tension=tensions, theta_0=0.0).cable_change
    assert hold(SpringTrunk(BARE, theta_0=0.0), tensions) == pytest.approx(expected, abs=10e-3)


def test_sag_leaves_slack_in_the_lower_cables() -> None:
    """With nothing wound, the upper cable holds the level trunk and the lower ones hang loose."""
    trunk = SpringTrunk(PAPER, theta_0=0.0)
    for _ in range(3000):
        tension = trunk.advance([0.0] * 3, STIFF, 1e-3)
    assert tension[0] > 1.0
    assert tension[1] == tension[2] == 0.0


def test_hanging_straight_it_stays_straight() -> None:
    trunk = SpringTrunk(PAPER)
    for _ in range(1000):
        assert trunk.advance([0.0] * 3, STIFF, 1e-3) == pytest.approx([0.0] * 3, abs=1e-9)
    assert trunk.curl == pytest.approx((0.0, 0.0), abs=1e-15)


def test_roll_turns_the_cables() -> None:
    """Pulling cable 2 of a trunk rolled by -120 deg is pulling cable 1 of one that is not."""
    one = hold(SpringTrunk(PAPER, theta_0=0.3), (8, 0, 0))
    two = hold(SpringTrunk(PAPER, theta_0=0.3, roll=-2 * math.pi / 3), (0, 8, 0))
    assert two == pytest.approx(one[[2, 0, 1]], abs=1e-9)


@pytest.mark.parametrize(
    "design", [PAPER, replace(PAPER, delta_theta=math.pi / 9, n_section=27, mass=BARE.mass.__class__())]
)
def test_lengths_are_those_of_the_bent_trunk(design: TrunkDesign) -> None:
    """In the plane of the bend exactly, across it to 1 % of the stroke."""
    curl = compute_curl(design)
    for bend in (0.1, 0.5, 1.0):
        q = np.zeros((design.n_joint, 2))
        q[:, 1] = bend * design.delta_theta  # Dorsal, towards cable 1; all joints alike.
        half, arm = design.delta_theta / 2, design.hole_to_joint
        common = (2 * arm * math.sin(half) * (1 - np.cos(q[:, 1] / 2))).sum()
        along = (2 * arm * math.cos(half) * np.sin(q[:, 1] / 2)).sum()
        change = lengths(design, q).change
        assert change[0] == pytest.approx(common + along)
        assert change[1:] == pytest.approx(np.full(2, common - along / 2), abs=1e-2 * design.cable_stroke)
    last = curl.common[-1] + curl.lever[-1] * design.cable_stroke
    assert last == pytest.approx(design.cable_stroke, rel=1e-3)


def test_no_cable_takes_more_than_the_stroke() -> None:
    """Beyond it the trunk is hard: what is wound further stretches the cable alone."""
    trunk = SpringTrunk(PAPER)
    more = PAPER.cable_stroke + 3e-3
    for k in range(4000):
        tension = trunk.advance([more * min(1.0, k / 2000), -0.2, -0.2], STIFF, 1e-3)
    assert trunk.taken[0] == pytest.approx(PAPER.cable_stroke, abs=1e-5)
    assert tension[0] == pytest.approx(2e4 * 3e-3, rel=0.01)


def test_a_broken_cable_pulls_nothing() -> None:
    trunk = SpringTrunk(PAPER)
    for _ in range(100):
        tension = trunk.advance([0.05, -0.1, -0.1], [0.0, 2e4, 2e4], 1e-3)
    assert list(tension) == [0.0, 0.0, 0.0]


@pytest.mark.parametrize("dt", [1e-3, 5e-3])
def test_a_released_trunk_loses_energy_only(dt: float) -> None:
    """Kinetic, elastic and potential energy, of a trunk let go from a full curl; without damping it must not grow."""
    design = replace(PAPER, joint=replace(PAPER.joint, damping_time=0.0))
    trunk = SpringTrunk(design, theta_0=0.5)
    hold(trunk, (20, 0, 0), 1.0)
    start = trunk.energy()
    energies = []
    for _ in range(round(4.0 / dt)):
        trunk.advance([-1.0] * 3, STIFF, dt)
        energies.append(trunk.energy())
    assert max(energies) <= start + 1e-9
    assert energies[-1] < start


def test_a_wrong_number_of_cables_is_refused() -> None:
    with pytest.raises(DriveError, match="2 cables"):
        SpringTrunk(PAPER).advance([0.0] * 2, [2e4] * 2, 1e-3)
