"""Noise model: the covariance that independent errors of bends make, and a discrepancy of its own for each chain."""

from dataclasses import replace

import numpy as np
import pytest

from spiraltrunk.calibration.noise_model import (
    Block,
    NoiseModel,
    build_covariance,
    compute_levers,
    factorise,
    fit_noise_models,
    whiten,
)
from spiraltrunk.design.presets import PAPER
from spiraltrunk.model.kinematics.frames import bend_rotation, section_frames

SECTIONS = np.linspace(1 / 15, 1.0, 15)
LEVERS = compute_levers(SECTIONS, np.arange(17) / 17, np.ones(17))


def _block(states, least=5e-4):
    count = 15 * states
    along = np.tile(SECTIONS, states)
    points = np.stack([along / 2, np.zeros(count), np.zeros(count)], axis=-1)
    at = np.stack([np.repeat(range(states), 15), np.tile(range(15), states)], axis=-1)
    stroke = 0.005 * np.repeat(range(states), 15)
    return Block(
        points=points, at=at, lever=np.tile(LEVERS, (states, 1)), stroke=stroke, weight=np.ones(count),
        least_discrepancy=least,
    )  # fmt: skip


def test_discrepancy_is_that_of_independent_errors_of_the_bends():
    """With many joints alike it is an integrated Wiener process, s^2 (3 t - s) / 2 for s <= t."""
    joint = (np.arange(20_000) + 0.5) / 20_000
    near, far = np.minimum.outer(SECTIONS, SECTIONS), np.maximum.outer(SECTIONS, SECTIONS)
    levers = compute_levers(SECTIONS, joint, np.ones(len(joint)))
    np.testing.assert_allclose(levers @ levers.T, near**2 * (3 * far - near) / 2, rtol=1e-4, atol=1e-12)
    model = NoiseModel(noise=1e-9, discrepancy=2e-3, turn=0.0, shift=0.0)
    got = build_covariance(_block(1), model)[::3, ::3]
    np.testing.assert_allclose(got, (2e-3) ** 2 * LEVERS @ LEVERS.T, atol=1e-15)


def test_levers_are_what_errors_of_bends_do_to_the_trunk():
    """Against the kinematics: each joint of the straight trunk bent by a little."""
    start = np.cumsum(PAPER.section_length) - PAPER.section_length
    ends, spread = np.cumsum(PAPER.section_length) / PAPER.length, PAPER.scale[:-1] ** -2.0
    levers = compute_levers(ends, start[1:] / PAPER.length, spread)
    bends = np.zeros((PAPER.n_joint, PAPER.n_joint, 2))
    bends[range(PAPER.n_joint), range(PAPER.n_joint), 1] = 1e-6 * spread
    frames = section_frames(PAPER, bend_rotation(bends))
    moved = (frames[..., :3, 3] + PAPER.section_length[:, None] * frames[..., :3, 0])[..., 1].T
    np.testing.assert_allclose(levers, moved / np.linalg.norm(moved[-1]), atol=1e-6)


@pytest.mark.slow
def test_a_chain_that_the_model_does_not_express_gets_a_discrepancy_of_its_own():
    """And bends no parameter: with one discrepancy for all chains the estimate would be off by many deviations."""
    draw, sharp = np.random.default_rng(5), NoiseModel(noise=1e-4, discrepancy=6e-4, turn=2e-3, shift=3e-4)
    blocks, true = [_block(6), _block(6)], [sharp, replace(sharp, discrepancy=2e-2)]
    jacobian = np.zeros((6, 15, 3, 2))
    jacobian[:, :, 1, 0] = 1e-2 * SECTIONS**2
    jacobian[:, :, 2, 1] = 1e-2 * SECTIONS * np.linspace(0.5, 1.0, 6)[:, None]
    jacobians = [jacobian.reshape(-1, 2), jacobian.reshape(-1, 2)[:, ::-1]]
    sizes = (factorise(block, model) for block, model in zip(blocks, true, strict=True))
    residuals = [factor @ draw.standard_normal(270) for factor in sizes]
    found = fit_noise_models(blocks, residuals, jacobians, np.eye(2), [sharp, sharp])
    assert found[0].noise == found[1].noise
    assert 0.7e-4 < found[0].noise < 1.4e-4
    assert 5e-4 <= found[0].discrepancy < 9e-4
    assert 1.2e-2 < found[1].discrepancy < 3.2e-2

    def estimate(models):
        normal, moment = np.eye(2), np.zeros(2)
        for block, model, residual, jacobian in zip(blocks, models, residuals, jacobians, strict=True):
            factor = factorise(block, model)
            normal += whiten(factor, jacobian).T @ whiten(factor, jacobian)
            moment += whiten(factor, jacobian).T @ whiten(factor, residual)
        return np.abs(np.linalg.solve(normal, moment)) / np.sqrt(np.diag(np.linalg.inv(normal)))

    assert estimate(found).max() < 3
    assert estimate([sharp, sharp]).max() > 10


def test_no_discrepancy_is_less_than_the_chains_least_one():
    block = _block(3, least=1e-2)
    draw = np.random.default_rng(1)
    residual, jacobian = 1e-5 * draw.standard_normal(135), 1e-2 * draw.standard_normal((135, 1))
    first = NoiseModel(noise=5e-4, discrepancy=2e-2)
    (found,) = fit_noise_models([block], [residual], [jacobian], np.eye(1), [first])
    assert 1e-2 <= found.discrepancy < 1.1e-2
