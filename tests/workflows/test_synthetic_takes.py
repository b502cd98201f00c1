"""Whether a take is a measurement is decided by its header, the same in validation and calibration."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from spiraltrunk.design.presets import PAPER
from spiraltrunk.mocap import SessionSettings
from spiraltrunk.mocap.protocol.protocol import Protocol, Run
from spiraltrunk.mocap.protocol.schedule import build_schedule
from spiraltrunk.mocap.recordings.motive_csv import load_motive
from spiraltrunk.mocap.recordings.motive_write import write_motive
from spiraltrunk.mocap.session.prediction import predict
from spiraltrunk.workflows.calibrate.recordings import Recordings, read_recordings
from spiraltrunk.workflows.validate.comparison import compare_to_model, compute_result
from spiraltrunk.workflows.virtual_session.synthetic_take import CameraOptions, build_synthetic_take

PROTOCOL = Protocol(name="short", runs=(Run(name="rest-000", kind="rest"),), axes="y-up")
NAMES = ("Take 7", "simulated load 3", "virtual capture rehearsal")


@pytest.fixture(params=[True, False], ids=["synthetic", "recorded"])
def is_synthetic(request: pytest.FixtureRequest) -> bool:
    return bool(request.param)


@pytest.fixture
def files(is_synthetic: bool, tmp_path: Path) -> list[str]:
    """Takes under several names, each with the header of a synthetic recording, or of one that Motive recorded."""
    run = PROTOCOL.runs[0]
    found = predict(PAPER, build_schedule(PAPER, PROTOCOL, run))
    paths = []
    for i, name in enumerate(NAMES):
        options = CameraOptions(rate=60.0, hold=0.8, move=0.4, seed=i)
        take = build_synthetic_take(PAPER, found.points, found.rotation, run.theta_0, options)
        take = replace(take, name=name, **({} if is_synthetic else {"comment": "first session, not calibrated"}))
        paths.append(str(write_motive(take, tmp_path / f"rest-000_{name.replace(' ', '-')}.csv")))
    return paths


def test_the_header_decides(files: list[str], is_synthetic: bool) -> None:
    takes = [load_motive(file, axes="y-up") for file in files]
    assert [take.name for take in takes] == list(NAMES)
    assert [take.is_synthetic for take in takes] == [is_synthetic] * len(NAMES)


def test_validation_and_calibration_agree(files: list[str], is_synthetic: bool) -> None:
    comparison = compare_to_model(PROTOCOL, {"rest-000": files}, SessionSettings(design=PAPER))
    result = compute_result(comparison)
    assert result["is_made_up"] == is_synthetic
    assert any("3 recordings are synthetic" in note for note in result["notes"]) == is_synthetic
    given = Recordings(
        protocol=PROTOCOL, design=PAPER, fitted={"rest-000": files[:2]}, held_out={"rest-000": files[2:]}
    )
    assert read_recordings(given).synthetic == (tuple(files) if is_synthetic else ())


def test_shapes_are_held_and_joined_by_straight_lines() -> None:
    """Without noise: each shape for its time, then every point on the way to the next, ever farther on."""
    points = np.random.default_rng(3).uniform(-0.2, 0.2, (3, PAPER.n_section, 3))
    rotation = np.broadcast_to(np.eye(3), (*points.shape, 3))
    options = CameraOptions(rate=20.0, hold=0.5, move=0.4, noise=0.0)
    take = build_synthetic_take(PAPER, points, rotation, 0.0, options)
    held, moved = options.hold_frames, options.move_frames
    assert len(take.time) == 3 * held + 2 * moved
    seen = np.stack([body.position for body in take.bodies[1:]], axis=1)
    for i, start in enumerate(np.arange(3) * (held + moved)):
        np.testing.assert_allclose(seen[start : start + held], np.tile(points[i], (held, 1, 1)), atol=1e-12)
        if i == 2:
            continue
        way = points[i + 1] - points[i]
        passed = seen[start + held : start + held + moved] - points[i]
        share = np.einsum("nij,ij->ni", passed, way) / (way**2).sum(axis=-1)
        np.testing.assert_allclose(passed, share[..., None] * way, atol=1e-12)
        assert (np.diff(share, axis=0, prepend=0.0, append=1.0) > 0.0).all()
