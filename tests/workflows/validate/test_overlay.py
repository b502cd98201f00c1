"""Measured and predicted shapes at every moment of a take."""

from dataclasses import replace

import numpy as np
import pytest

from spiraltrunk.design import presets
from spiraltrunk.mocap.protocol.toml import load_protocol
from spiraltrunk.mocap.session.session import SessionSettings
from spiraltrunk.mocap.signal.registration import read_alignment
from spiraltrunk.workflows.validate import overlay
from spiraltrunk.workflows.validate.comparison import compare_to_model
from spiraltrunk.workflows.validate.overlay import build_overlays
from spiraltrunk.workflows.virtual_session.printed_trunk import draw_printed_trunk
from spiraltrunk.workflows.virtual_session.session import simulate_session, write_session

PAPERS = np.isin(np.arange(1, 19), (2, 4, *range(6, 19)))
"""Sections with markers in a virtual session."""


@pytest.fixture(scope="module")
def session(tmp_path_factory):
    """Protocol and takes of a short bend."""
    folder = tmp_path_factory.mktemp("session") / "virtual"
    packaged = load_protocol("paper")
    run = replace(packaged.run("bend-dorsal"), steps=3, step=0.03)
    trunk = draw_printed_trunk(presets.PAPER, 0)
    runs = simulate_session(presets.PAPER, trunk, replace(packaged, runs=(run,)), is_simulated=False)
    files = write_session(presets.PAPER, runs, 0, folder)
    return load_protocol(folder / "protocol.toml"), [str(file) for file in files if file.suffix == ".csv"]


@pytest.fixture(scope="module", params=["base", "run", "shape"])
def comparison(request, session):
    protocol, files = session
    settings = SessionSettings(design=presets.PAPER, alignment=read_alignment(request.param))
    return compare_to_model(protocol, {"bend-dorsal": files}, settings)


def test_the_mean_over_a_held_shape_is_the_comparison_s_distance(comparison):
    (run,) = build_overlays(comparison)
    means = []
    for take in run.takes:
        held = [take.points[take.is_held & (take.shape == i)] for i in range(4)]
        means.append([np.nanmedian(points[:, PAPERS], axis=0) for points in held])
    distance = np.linalg.norm(np.mean(means, axis=0) - run.predicted[:, PAPERS], axis=-1)
    assert distance == pytest.approx(comparison.deviations[0].distance[:, PAPERS], abs=3e-4)


def test_each_moment_has_the_nearest_shape_and_labels_name_the_pull(comparison):
    (run,) = build_overlays(comparison)
    assert run.labels == tuple(f"cable 1 in by {mm} mm" for mm in (0, 30, 60, 90))
    take = run.takes[0]
    assert (np.diff(take.shape) >= 0).all()
    assert set(take.shape) == {0, 1, 2, 3}
    assert 0 < take.is_held.sum() < len(take.time)


def test_gaps_are_recorded_sections_that_were_not_seen(comparison):
    (run,) = build_overlays(comparison)
    take = run.takes[0]
    is_gap = np.isnan(take.points).any(axis=-1) & PAPERS
    moment = int(np.flatnonzero(is_gap.any(axis=1))[0])
    assert take.list_gaps(moment) == [int(i) + 1 for i in np.flatnonzero(is_gap[moment])]
    assert np.array_equal(take.recorded, PAPERS)
    assert np.array_equal(np.isnan(run.compute_distance(0)), is_gap | ~PAPERS)


def test_a_long_take_is_thinned(comparison, monkeypatch):
    monkeypatch.setattr(overlay, "MOST_MOMENTS", 50)
    take = build_overlays(comparison)[0].takes[0]
    assert 25 < len(take.time) <= 50
