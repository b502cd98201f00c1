"""C3D files, written by the package itself, are read as what they say."""

from __future__ import annotations

import resource
import subprocess
import sys

import numpy as np
import pytest

from spiraltrunk.errors import MissingPackage, TakeError
from spiraltrunk.mocap import load_take
from spiraltrunk.mocap.recordings import c3d
from spiraltrunk.mocap.recordings.c3d import load_c3d

LABELS = ["section_01:Marker1", "section_01:Marker2", "loose"]


@pytest.fixture
def path(tmp_path):
    ezc3d = pytest.importorskip("ezc3d", reason="ezc3d is not installed")

    def write(points, unit="mm", rate=120.0, labels=LABELS, residuals=None):
        content = ezc3d.c3d()
        content["parameters"]["POINT"]["RATE"]["value"] = [rate]
        content["parameters"]["POINT"]["UNITS"]["value"] = [unit]
        content["parameters"]["POINT"]["LABELS"]["value"] = list(labels)
        shaped = np.ones((4, len(labels), len(points)))
        shaped[:3] = np.moveaxis(points, -1, 0).transpose(0, 2, 1)
        content["data"]["points"] = shaped
        if residuals is not None:
            content["data"]["meta_points"]["residuals"] = residuals
        file = tmp_path / "take.c3d"
        content.write(str(file))
        return file

    return write


def points():
    return 100.0 * np.arange(5 * 3 * 3, dtype=float).reshape(5, 3, 3) / 45


def test_markers_come_in_metres_and_our_axes(path):
    take = load_take(path(points()), axes="z-up")
    assert (take.rate, len(take.frame), [marker.name for marker in take.markers]) == (120.0, 5, LABELS)
    np.testing.assert_allclose(take.markers[1].position, 1e-3 * points()[:, 1][:, [0, 2, 1]] * [1, 1, -1], atol=1e-8)
    np.testing.assert_allclose(np.diff(take.time), 1 / 120)
    assert take.bodies == ()


def test_what_was_not_seen_is_not_a_number(path):
    hidden = points()
    hidden[2, 0] = np.nan
    take = load_c3d(path(hidden), axes="y-up")
    np.testing.assert_array_equal(take.markers[0].is_seen, [True, True, False, True, True])


@pytest.mark.parametrize("unit", ["furlong", ""])
def test_other_units_are_refused(unit, path):
    with pytest.raises(TakeError, match="POINT:UNITS"):
        load_c3d(path(points(), unit=unit), axes="y-up")


def test_what_is_no_c3d_is_refused(path, tmp_path):
    file = path(points())
    data = file.read_bytes()
    for text in (b"", b"Format Version,1.23", data[:1000], data[:300]):
        file.write_bytes(text)
        with pytest.raises(TakeError, match=r"take\.c3d"):
            load_c3d(file, axes="y-up")
    with pytest.raises(TakeError):
        load_take(tmp_path / "missing.c3d", axes="y-up")
    with pytest.raises(TakeError, match="export the take"):
        load_take(tmp_path / "take.tak", axes="y-up")


def test_without_the_package_the_extra_is_named(path, monkeypatch):
    file = path(points())
    monkeypatch.setitem(sys.modules, "ezc3d", None)
    with pytest.raises(MissingPackage, match=r"spiraltrunk\[mocap\]"):
        load_c3d(file, axes="y-up")


def test_a_file_that_is_cut_off_is_noted(path):
    file = path(np.random.default_rng(0).normal(0.0, 100.0, (400, 3, 3)))
    assert load_c3d(file, axes="y-up").notes == ()
    data = file.read_bytes()
    file.write_bytes(data[: len(data) - 200 * 3 * 4 * 4])
    take = load_c3d(file, axes="y-up")
    assert len(take.frame) < 400
    assert take.notes == (f"the header says 400 frames, the file has {len(take.frame)}",)


def _change_group(file):
    """Put a parameter into a group that there is not, with which ezc3d reads beyond its memory."""
    data = bytearray(file.read_bytes())
    data[data.index(b"\x01LABELS")] = 0x80
    file.write_bytes(data)


def test_a_file_on_which_ezc3d_dies_is_refused(path, tmp_path):
    file = path(points())
    _change_group(file)
    code = "import ezc3d, sys; ezc3d.c3d(sys.argv[1])"
    limited = lambda: resource.setrlimit(resource.RLIMIT_CORE, (0, 0))  # noqa: E731
    died = subprocess.run([sys.executable, "-c", code, str(file)], check=False, capture_output=True, preexec_fn=limited)
    assert died.returncode < 0
    with pytest.raises(TakeError, match=r"take\.c3d.*is it damaged\?; allowed: a C3D file that ezc3d reads in 30 s"):
        load_c3d(file, axes="y-up")


def test_a_file_that_takes_too_long_or_too_much_is_refused(path, monkeypatch):
    file = path(points())
    for name in ("_SECONDS", "_MEMORY"):
        with monkeypatch.context() as patch:
            patch.setattr(c3d, name, 0 if name == "_SECONDS" else 1 << 24)
            with pytest.raises(TakeError, match="is it damaged"):
                load_c3d(file, axes="y-up")
    assert len(load_c3d(file, axes="y-up").frame) == 5
