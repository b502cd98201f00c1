"""Derivatives by cables against differences of equilibria solved anew; those by parameters are in tests/calibration."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from spiraltrunk.design import TrunkDesign, presets
from spiraltrunk.errors import ModelError
from spiraltrunk.model import statics
from spiraltrunk.model.kinematics.shape import Shape
from spiraltrunk.model.statics import sensitivities
from spiraltrunk.model.statics.equilibrium import StaticsOptions
from spiraltrunk.model.statics.loads import Loads

SHARP = StaticsOptions(tolerance=1e-11)

STAND = {"theta_0": 0.7, "roll": 0.4, "loads": Loads(mass=0.05, section=12, force=(0.1, 0.05, -0.1))}
"""Nothing symmetric, so that no slope is zero by chance."""

TENSIONS = [(0.0, 0.0, 0.0), (0.5, 0.1, 0.0), (2.0, 0.3, 1.0), (12.0, 0.0, 1.0), (9.0, 8.0, 0.5)]
"""From slack to many joints shut."""


def difference(solve, step: float) -> np.ndarray:
    """Central difference of section ends."""
    return (solve(step).points - solve(-step).points) / (2 * step)


def assert_close(ours: np.ndarray, other: np.ndarray, part: float = 2e-5) -> None:
    np.testing.assert_allclose(ours, other, rtol=0, atol=part * max(np.abs(other).max(), 1e-6))


def equilibrium(tension, design: TrunkDesign = presets.PAPER) -> Shape:
    return statics.solve(design, tension=tension, options=SHARP, **STAND)


@pytest.mark.parametrize("tension", TENSIONS)
def test_slopes_by_tension_are_the_differences(tension: tuple[float, float, float]) -> None:
    tension = np.maximum(tension, 1e-3)
    shape = equilibrium(tension)
    slopes = sensitivities.by_cables(presets.PAPER, shape, **STAND)
    for c, unit in enumerate(np.eye(3)):

        def again(step: float, unit=unit) -> Shape:
            return statics.solve(presets.PAPER, tension=tension + step * unit, start=shape, options=SHARP, **STAND)

        assert_close(slopes.points_by_tension[..., c], difference(again, 1e-5))
        pulled = (again(1e-5).cable_change - again(-1e-5).cable_change) / 2e-5
        np.testing.assert_allclose(slopes.pull_by_tension[:, c], pulled, rtol=1e-4, atol=1e-9)


@pytest.mark.parametrize("tension", TENSIONS[1:])
def test_slopes_by_pull_are_the_differences_and_slack_cables_have_none(tension: tuple[float, float, float]) -> None:
    shape = equilibrium(tension)
    slopes = sensitivities.by_cables(presets.PAPER, shape, **STAND)
    taut = shape.forces.cable_tension > 0
    held = np.where(taut, shape.cable_change, -0.1)
    for c, unit in enumerate(np.eye(3)):
        if not taut[c]:
            assert not slopes.points_by_pull[..., c].any()
            continue

        def again(step: float, unit=unit) -> Shape:
            return statics.solve(presets.PAPER, pull=held + step * unit, start=shape, options=SHARP, **STAND)

        assert_close(slopes.points_by_pull[..., c], difference(again, 1e-7), 2e-4)


def test_friction_is_in_the_slopes() -> None:
    design = replace(presets.PAPER, cable=replace(presets.PAPER.cable, friction=0.2))
    shape = statics.solve(design, tension=(4.0, 0.0, 0.0), options=SHARP, **STAND)
    slopes = sensitivities.by_cables(design, shape, **STAND)
    more = statics.solve(design, tension=(4.001, 0.0, 0.0), start=shape, options=SHARP, **STAND)
    assert_close(slopes.points_by_tension[..., 0], (more.points - shape.points) / 1e-3, 2e-3)


def test_pull_by_tension_is_symmetric_and_positive() -> None:
    give = sensitivities.by_cables(presets.PAPER, equilibrium((2.0, 0.3, 1.0)), **STAND).pull_by_tension
    np.testing.assert_allclose(give, give.T, rtol=1e-10)
    assert np.linalg.eigvalsh(give).min() > 0


def test_wrong_stand_and_batches_are_refused() -> None:
    shape = equilibrium((2.0, 0.3, 1.0))
    with pytest.raises(ModelError, match="moments"):
        sensitivities.by_cables(presets.PAPER, shape)
    batch = statics.solve(presets.PAPER, tension=np.ones((2, 3)))
    with pytest.raises(ModelError, match="one shape"):
        sensitivities.by_cables(presets.PAPER, batch)
