"""Single joints on the bench: laws that are known come back, and a real print departs from the beam law."""

import math
from pathlib import Path

import numpy as np
import pytest

from spiraltrunk.calibration.joint_bench_csv import load_static_loads
from spiraltrunk.calibration.joint_bench_fit import fit_ring_down, fit_static
from spiraltrunk.errors import ModelError

BEND = np.radians([0, 5, 10, 15, 20, 22, 24, 26, 28, 30])
ARM = 0.05
SHARED = Path(__file__).parents[2].parent / "shared" / "bench" / "static_load.csv"


def _mass(moment):
    return moment / 9.81 / ARM


def test_a_beam_is_a_beam():
    fit = fit_static(BEND, _mass(0.3 * BEND), ARM)
    assert fit.is_beam
    assert fit.beam.value == pytest.approx(0.3, rel=1e-9)


def test_faces_that_meet_are_found():
    at = math.radians(24)
    fit = fit_static(BEND, _mass(0.3 * BEND + 2.0 * np.maximum(0, BEND - at)), ARM)
    assert fit.stiffness.value == pytest.approx(0.3, rel=1e-6)
    assert fit.faces.value == pytest.approx(2.0, rel=1e-6)
    assert fit.faces_from.value == pytest.approx(at)
    assert fit.faces_from.low < at < fit.faces_from.high
    assert fit.onset.value == 0.0
    np.testing.assert_allclose(fit.moment([0.1, at]), [0.03, 0.3 * at], rtol=1e-6)


def test_a_moment_from_the_first_degrees_on_is_found():
    moment = 0.2 * BEND + 0.05 * (1 - np.exp(-BEND / math.radians(2)))
    fit = fit_static(BEND, _mass(moment), ARM)
    assert fit.onset.value == pytest.approx(0.05, rel=1e-6)
    assert fit.stiffness.value == pytest.approx(0.2, rel=1e-6)
    assert fit.beam.value > fit.stiffness.value


def test_95_percent_intervals_hold_the_truth_about_95_times_in_100():
    draw = np.random.default_rng(0)
    inside = 0
    for _ in range(60):
        fit = fit_static(BEND, _mass(np.maximum(0.3 * BEND + 0.003 * draw.standard_normal(BEND.size), 0)), ARM)
        inside += fit.beam.low < 0.3 < fit.beam.high
    assert 51 <= inside <= 60  # Fewer has a chance of 1 in 500 for an interval of 95 %.


def test_intervals_of_faces_hold_the_truth_most_times():
    """Where they meet, how stiff they are and the stiffness before, together: the law is chosen from the data, too."""
    draw, at = np.random.default_rng(4), math.radians(24)
    law = 0.3 * BEND + 2.0 * np.maximum(0, BEND - at)
    inside = np.zeros(3, int)
    for _ in range(40):
        fit = fit_static(BEND, _mass(np.maximum(law + 0.003 * draw.standard_normal(BEND.size), 0)), ARM)
        parts = ((fit.stiffness, 0.3), (fit.faces, 2.0), (fit.faces_from, at))
        inside += [part.low < truth < part.high for part, truth in parts]
    assert (inside >= 34).all()  # Fewer has a chance of 1 in 300 each for an interval of 95 %.


def test_a_ring_down_is_met_by_its_law():
    t, a, *_ = _ring()
    np.testing.assert_allclose(fit_ring_down(t + 3.0, a, 1e-5).signal(t), a, atol=1e-6)


def _ring(ratio=0.13, hertz=36.3, noise=0.0, inertia=1.58e-5):
    t = np.arange(0, 0.4, 1 / 800)
    damped = 2 * math.pi * hertz
    natural = damped / math.sqrt(1 - ratio**2)
    a = 20 * np.exp(-ratio * natural * t) * np.cos(damped * t + 0.4) + 0.3
    return (
        t,
        a + noise * np.random.default_rng(1).standard_normal(t.size),
        inertia * natural**2,
        2 * ratio * natural * inertia,
    )


@pytest.mark.parametrize("ratio", [0.01, 0.05, 0.13, 0.3])
@pytest.mark.parametrize("hertz", [4.0, 36.3, 120.0])
def test_a_ring_down_gives_its_stiffness_and_damping(ratio, hertz):
    t, a, stiffness, damping = _ring(ratio, hertz)
    fit = fit_ring_down(t, a, 1.58e-5)
    assert fit.frequency.value == pytest.approx(hertz, rel=1e-6)
    assert fit.damping_ratio.value == pytest.approx(ratio, rel=1e-5)
    assert fit.stiffness.value == pytest.approx(stiffness, rel=1e-5)
    assert fit.damping.value == pytest.approx(damping, rel=1e-5)


def test_the_inertias_uncertainty_is_in_the_stiffness():
    t, a, stiffness, _ = _ring(noise=0.2)
    fit = fit_ring_down(t, a, 1.58e-5, 0.05 * 1.58e-5)
    assert fit.stiffness.low < stiffness < fit.stiffness.high
    assert (fit.stiffness.high - fit.stiffness.low) / 2 == pytest.approx(1.97 * 0.05 * stiffness, rel=0.05)


@pytest.mark.parametrize(
    ("bend", "mass"),
    [([0, 0.1], [0, 1]), ([0, 0.1, 0.2, math.nan], [0, 1, 2, 3]), ([0, 0.1, 0.2, 0.3], [0, -1, 2, 3]), ("x", [1]),
     ([0.1, 0.2, 0.3], [1, 2]), ([0.1, 0.2, 0.3, 0.4], [1e-323] * 4), ([0.1, 0.2, 0.3, 0.4], [1e-18] * 4)],
)  # fmt: skip
def test_bad_loads_are_refused(bend, mass):
    with pytest.raises(ModelError, match="allowed"):
        fit_static(bend, mass, ARM)


def test_bad_records_are_refused():
    t, a, *_ = _ring()
    for args in ((t[:10], a[:10], 1e-5), (t, a[:-1], 1e-5), (t[::-1], a, 1e-5), (t, a, math.nan), (t, a, -1.0)):
        with pytest.raises(ModelError, match="allowed"):
            fit_ring_down(*args)
    with pytest.raises(ModelError, match="every sample is the same"):
        fit_ring_down(t, 0 * a, 1e-5)
    with pytest.raises(ModelError, match=r"above its noise|no decaying"):
        fit_ring_down(t, np.random.default_rng(2).standard_normal(t.size), 1e-5)
    with pytest.raises(ModelError, match="ring-down"):
        fit_ring_down(t, np.exp(20 * t) * np.cos(200 * t), 1e-5)


@pytest.mark.skipif(not SHARED.exists(), reason="the bench record of another group's print is not beside the project")
def test_a_real_print_leaves_the_beam_law():
    """Four joints: each starts stiffer than it goes on, and in two the faces meet."""
    fits = {loads.joint: fit_static(loads.bend, loads.mass, loads.lever_arm) for loads in load_static_loads(SHARED)}
    assert sorted(fits) == [1, 8, 11, 13]
    assert not any(fit.is_beam for fit in fits.values())
    assert all(fit.error < 0.5 * fit.beam_error for fit in fits.values())
    assert [joint for joint, fit in fits.items() if fit.faces.value > 0] == [1, 11]
