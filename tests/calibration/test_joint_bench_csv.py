"""Bench records: read, or refused with file, line and column."""

import numpy as np
import pytest

from spiraltrunk.calibration.joint_bench_csv import load_ring_down, load_static_loads
from spiraltrunk.errors import TakeError

HEAD = "joint,lever_arm_m,mass_g,angle_deg\n"


def _write(tmp_path, text):
    path = tmp_path / "record.csv"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_readings_are_sorted_by_joint_and_in_si(tmp_path, end):
    rows = "2,0.05,100,10\n1,0.07,0,0\n2,0.05,200,20\n\n"
    first, second = load_static_loads(_write(tmp_path, ("\ufeff" + HEAD + rows).replace("\n", end)))
    assert (first.joint, second.joint) == (1, 2)
    np.testing.assert_allclose(second.mass, [0.1, 0.2])
    np.testing.assert_allclose(second.bend, np.radians([10, 20]))
    np.testing.assert_allclose(second.lever_arm, 0.05)


def test_a_ring_down_is_two_columns(tmp_path):
    t, a = load_ring_down(_write(tmp_path, "time_s,acceleration\n0,1\n0.1,-1\n"))
    np.testing.assert_array_equal(t, [0, 0.1])
    np.testing.assert_array_equal(a, [1, -1])


@pytest.mark.parametrize(
    ("text", "words"),
    [("", "columns"), ("a,b\n1,2\n", "columns"), (HEAD, "no reading"), (HEAD + "1,2,3\n", "line 2: 3 cells"),
     (HEAD + "1,0.1,x,3\n", "line 2, column 3"), (HEAD + "1,0.1,1,3\n1,nan,1,3\n", "line 3, column 2"),
     (HEAD + "1.5,0.1,1,3\n", "whole number"), (HEAD + "\n\n0,0.1,1,3\n", "line 4, column 1"),
     (HEAD + "1,0.1,1,-3\n", "angle_deg is -3; allowed: 0 to 180"), (HEAD + "1,70,1,3\n", "lever_arm_m is 70"),
     (HEAD + "1,0.1,1e300,3\n", "line 2, column 3"), (b"\xff\xfe\x00", "UTF-8")],
)  # fmt: skip
def test_what_is_no_record_is_refused(tmp_path, text, words):
    with pytest.raises(TakeError, match=words):
        load_static_loads(_write(tmp_path, text))


@pytest.mark.parametrize(("load", "columns"), [(load_static_loads, HEAD), (load_ring_down, "time_s,acceleration")])
def test_a_missing_record_is_told_with_its_columns(tmp_path, load, columns):
    columns = columns.strip().replace(",", ", ")
    with pytest.raises(TakeError, match=f"No such file or directory; allowed: a joint bench record, CSV of {columns}"):
        load(tmp_path / "none.csv")
