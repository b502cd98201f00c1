"""Real recordings, where they are at hand: what is in them comes out, by an independent reading with the csv module."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

from spiraltrunk.mocap.recordings.motive_csv import load_motive

FOLDER = Path(__file__).parents[4] / "shared" / "mocap"
FILES = {
    "pathviewr_motive_example_data.csv": (3, 0, 934, 1.0),
    "july-29_group-I_16-20_truncated.csv": (3, 0, 4001, 1.0),
    "2020-03-07_Ard_her_20-317L_4jts_7wng_ROM_001.csv": (0, 11, 2032, 1e-3),
    "sample_optitrack_take.csv": (1, 12, 250, 1.0),
}
"""Rigid bodies, markers, frames and unit [m]."""

pytestmark = pytest.mark.skipif(not FOLDER.exists(), reason="the real recordings are not here")


@pytest.mark.parametrize("name", FILES)
def test_a_real_recording_is_read_in_full(name):
    n_body, n_marker, n_frame, unit = FILES[name]
    take = load_motive(FOLDER / name, axes="y-up")
    assert (len(take.bodies), len(take.markers), len(take.frame)) == (n_body, n_marker, n_frame)
    rows = list(csv.reader((FOLDER / name).open(newline="")))
    start = next(i for i, row in enumerate(rows) if row and row[0] == "Frame")
    values = np.array([[float(cell or "nan") for cell in row] for row in rows[start + 1 :]])
    np.testing.assert_array_equal(take.frame, values[:, 0])
    assert np.abs(take.time - values[:, 1]).max() < 1e-3
    place = [i for i, what in enumerate(rows[start - 1]) if what == "Position"]
    read = np.hstack([track.position for track in (*take.bodies, *take.markers)])
    np.testing.assert_allclose(read, unit * values[:, place], rtol=1e-12)
    if n_body:
        turns = [i for i, what in enumerate(rows[start - 1]) if what == "Rotation"]
        read = np.hstack([body.quaternion_wxyz[:, [1, 2, 3, 0]] for body in take.bodies])
        np.testing.assert_allclose(read, values[:, turns], atol=2e-6)


def test_what_is_odd_about_them_is_told():
    notes = load_motive(FOLDER / "pathviewr_motive_example_data.csv", axes="y-up").notes
    assert "the header says 190951 frames, the file has 934" in notes
    assert load_motive(FOLDER / "sample_optitrack_take.csv", axes="y-up").notes == ()


def test_a_rigid_body_of_three_markers_lies_in_their_middle_when_its_pivot_was_not_moved():
    take = load_motive(FOLDER / "sample_optitrack_take.csv", axes="y-up")
    markers = np.mean([take.marker(f"Rigid Body 1:Marker{i}").position for i in (1, 2, 3)], axis=0)
    seen = np.isfinite(markers).all(axis=1)
    assert seen.sum() > 200
    assert np.linalg.norm(take.bodies[0].position - markers, axis=1)[seen].max() < 2e-3
