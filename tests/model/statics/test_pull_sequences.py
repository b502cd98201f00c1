"""The paper's pulls in the equilibrium: lengths come out as asked, and where nothing rubs the order does not matter."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from spiraltrunk.design import presets
from spiraltrunk.design.presets import PAPER
from spiraltrunk.design.trunk import ventral_cables
from spiraltrunk.errors import ModelError
from spiraltrunk.model import reference, statics
from spiraltrunk.model.kinematics.shape import Status
from spiraltrunk.model.statics import pull_sequences

MM = 1e3


@pytest.mark.parametrize("theta_deg", [-45, 0, 45, 135])
def test_both_models_rest_alike(theta_deg: int) -> None:
    """Two laws written apart, moments joint by joint and a minimum of energy, with the gripper in both."""
    theta_0 = math.radians(theta_deg)
    papers = reference.rest(PAPER, theta_0, as_authors=False)
    np.testing.assert_allclose(MM * pull_sequences.rest(PAPER, theta_0).points, MM * papers.points, atol=1e-4)


def test_the_gripper_weighs() -> None:
    trunk = pull_sequences.carry_gripper(PAPER)
    assert trunk.gripper is None
    assert trunk.total_mass == pytest.approx(PAPER.total_mass, rel=1e-12)
    assert pull_sequences.carry_gripper(trunk) is trunk


def test_tensions_are_put_on() -> None:
    shape = pull_sequences.pull_tensions(PAPER, [5.0, 0.0, 2.0], 0.3, friction=0.1)
    np.testing.assert_array_equal(shape.forces.cable_tension, [5.0, 0.0, 2.0])
    expected = statics.solve(pull_sequences.carry_gripper(PAPER), tension=[5.0, 0.0, 2.0], theta_0=0.3, friction=0.1)
    np.testing.assert_array_equal(shape.points, expected.points)


@pytest.mark.parametrize("theta_0", [0.0, math.pi / 2, 3 * math.pi / 4])
@pytest.mark.parametrize("friction", [0.0, 0.1])
def test_cable_1_changes_by_what_was_asked(theta_0: float, friction: float) -> None:
    rest = pull_sequences.rest(PAPER, theta_0).cable_change[0]
    dorsal = pull_sequences.pull_dorsal(PAPER, 0.05, theta_0, friction=friction)
    assert dorsal.cable_change[0] - rest == pytest.approx(0.05, abs=2e-6)
    np.testing.assert_array_equal(dorsal.forces.cable_tension[1:], 0.0)
    ventral = pull_sequences.pull_ventral(PAPER, 0.05, theta_0, friction=friction)
    assert ventral.cable_change[0] - rest == pytest.approx(-0.05, abs=2e-6)
    assert ventral.cable_change[1] == pytest.approx(ventral.cable_change[2], abs=1e-6)
    assert ventral.forces.cable_tension[0] == 0.0


@pytest.mark.parametrize("n_cable", [4, 6])
def test_a_ventral_pull_leaves_all_but_the_ventral_cables_slack(n_cable: int) -> None:
    """The trunk bends in its plane by symmetry; lateral cables would pull it out, and dorsal ones against itself."""
    angles = tuple(2 * math.pi * i / n_cable for i in range(n_cable))
    design = replace(PAPER, cable=replace(PAPER.cable, angles=angles))
    shape = pull_sequences.pull_ventral(design, 0.04)
    assert shape.status == Status.CONVERGED
    assert abs(shape.points[-1, 2]) < 1e-6
    np.testing.assert_array_equal(shape.forces.cable_tension[~ventral_cables(design)], 0.0)
    assert shape.cable_change[0] - pull_sequences.rest(design).cable_change[0] == pytest.approx(-0.04, abs=2e-6)


def test_twist_pulls_cable_2_from_its_length_after_cable_1() -> None:
    first = pull_sequences.pull_dorsal(PAPER, 0.06, friction=0.1)
    both = pull_sequences.pull_twist(PAPER, 0.06, 0.03, friction=0.1)
    assert MM * (both.cable_change - first.cable_change)[:2] == pytest.approx([0.0, 30.0], abs=2e-3)
    assert both.forces.cable_tension[2] == 0.0


def test_without_friction_only_the_lengths_count() -> None:
    """Energy has no memory: the same lengths by another way are the same shape."""
    twist = pull_sequences.pull_twist(PAPER, 0.06, 0.03, friction=0.0)
    goal = [twist.cable_change[0], twist.cable_change[1], 0.0]
    together = pull_sequences.pull_cables(PAPER, goal, friction=0.0)
    np.testing.assert_allclose(MM * together.points, MM * twist.points, atol=1e-2)


def test_nothing_pulled_is_rest() -> None:
    rest = pull_sequences.rest(PAPER, 0.3)
    for shape in (
        pull_sequences.pull_dorsal(PAPER, 0.0, 0.3),
        pull_sequences.pull_ventral(PAPER, 0.0, 0.3),
        pull_sequences.pull_cables(PAPER, [0.0, 0.0, 0.0], 0.3),
    ):
        np.testing.assert_allclose(MM * shape.points, MM * rest.points, atol=1e-3)


def test_full_curl_takes_no_more() -> None:
    most = pull_sequences.pull_ventral(PAPER, 0.122)
    np.testing.assert_allclose(np.degrees(most.joint_angle), 30.0, atol=0.1)
    assert pull_sequences.find_shut(PAPER, most).all()
    assert pull_sequences.find_shut(PAPER, pull_sequences.pull_dorsal(PAPER, 0.131)).all()
    assert not pull_sequences.find_shut(PAPER, pull_sequences.rest(PAPER)).any()


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (
            lambda: pull_sequences.pull_dorsal(PAPER, -1e-3),
            "pull is -0.001 m; allowed: .*at most 0.131157 m",
        ),
        (lambda: pull_sequences.pull_dorsal(PAPER, math.nan), "pull is nan"),
        (lambda: pull_sequences.pull_ventral(PAPER, 0.2), "lengthening is 0.2 m"),
        (lambda: pull_sequences.pull_twist(PAPER, 0.01, 0.2), "pull_2 is 0.2 m"),
        (
            lambda: pull_sequences.pull_twist(presets.get("spirob-15"), 0.01, 0.01),
            "2 cables; allowed for a twist: three or more",
        ),
        (lambda: pull_sequences.pull_cables(PAPER, [0.0, 1.0, 0.0]), "change is 1 m"),
        (lambda: pull_sequences.pull_cables(PAPER, [0.0, 0.01]), r"change has shape (2,.; allowed: (3,."),
        (
            lambda: pull_sequences.pull_cables(PAPER, ["a", 0.0, 0.0]),
            "change is .'a', 0.0, 0.0.; allowed: numbers",
        ),
        (lambda: pull_sequences.pull_dorsal(PAPER, "a"), "pull is 'a'; allowed: numbers"),
        (lambda: pull_sequences.pull_dorsal(PAPER, [0.01, 0.02]), "pull has shape (2,.; allowed: one number"),
        (lambda: pull_sequences.pull_twist(PAPER, 0.01, None), "pull_2 is None; allowed: numbers"),
        (lambda: pull_sequences.pull_dorsal(PAPER, 0.05, np.zeros(3)), "theta_0 has shape (3,.; allowed: one number"),
        (
            lambda: pull_sequences.pull_cables(PAPER, [0.05, 0.0, 0.0], [0.0, 1.0]),
            "theta_0 has shape (2,.; allowed: one number",
        ),
    ],
)
def test_what_cannot_be_pulled_is_refused(call: object, said: str) -> None:
    with pytest.raises(ModelError, match=said.replace("(", r"\(")):
        call()


def test_a_cable_1_that_is_not_dorsal_is_refused() -> None:
    turned = replace(PAPER, cable=replace(PAPER.cable, angles=(1.0, 3.0, 5.0)))
    with pytest.raises(ModelError, match="cable 1 dorsal"):
        pull_sequences.pull_dorsal(turned, 0.01)


def test_winding_a_cable_with_the_others_let_out_is_the_dorsal_pull():
    wound = pull_sequences.wind_cables(PAPER, [0.08, -0.12, -0.12])
    pulled = pull_sequences.pull_dorsal(PAPER, 0.08)
    assert wound.points == pytest.approx(pulled.points, abs=1e-8)
    assert list(wound.forces.cable_tension[1:]) == [0.0, 0.0]


def test_winding_goes_on_from_a_start_and_back_to_rest():
    start = pull_sequences.wind_cables(PAPER, [0.08, -0.03, -0.12], 1.0, 0.4)
    back = pull_sequences.wind_cables(PAPER, [-0.12, -0.12, -0.12], 1.0, 0.4, start=start)
    rest = pull_sequences.wind_cables(PAPER, [-0.12, -0.12, -0.12], 1.0, 0.4)
    assert back.points == pytest.approx(rest.points, abs=1e-8)
    assert np.abs(start.points - rest.points).max() > 0.05


def test_winding_stalls_where_cables_are_wound_against_each_other():
    assert pull_sequences.wind_cables(PAPER, [0.02, 0.02, 0.02]).status == Status.STALLED


@pytest.mark.parametrize("pull", [[0.0, 0.0], [0.0, math.nan, 0.0], [0.0, 0.0, 1.0]])
def test_winding_refuses_what_is_no_pull(pull):
    with pytest.raises(ModelError, match="pull"):
        pull_sequences.wind_cables(PAPER, pull)
