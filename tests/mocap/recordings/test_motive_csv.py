"""Motive CSVs of every kind are read as what they say, and what is wrong is told with its place."""

from __future__ import annotations

import io
import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from spiraltrunk.errors import TakeError
from spiraltrunk.files import text_lines
from spiraltrunk.mocap.recordings import motive_cells, motive_header
from spiraltrunk.mocap.recordings.motive_csv import load_motive, read_motive
from spiraltrunk.mocap.recordings.motive_write import format_motive, write_motive
from spiraltrunk.mocap.recordings.take import Body, Marker, Take, find_stale

POSE = [0.1, 0.2, 0.3, 0.927362, 1.5, -0.25, 0.125, 0.0002]
OTHER = [0.1, 0.2, 0.3, 0.927362, 1.6, -0.25, 0.125, 0.0003]
BLANK = [""] * 8


def refuse(read, data, **more) -> TakeError:
    with pytest.raises(TakeError) as caught:
        read(data, **more)
    assert str(caught.value).startswith("'take.csv'")
    return caught.value


def test_a_rigid_body_is_read(write, body, read):
    take = read(write(body("trunk"), [POSE, BLANK, OTHER]))
    assert (take.name, take.started, take.rate) == ("Take 1", "2026-01-05 03.49.50.755 PM", 100.0)
    np.testing.assert_array_equal(take.frame, [0, 1, 2])
    np.testing.assert_allclose(take.time, [0.0, 0.01, 0.02])
    found = take.body("trunk")
    np.testing.assert_allclose(found.position, [[1.5, -0.25, 0.125], [np.nan] * 3, [1.6, -0.25, 0.125]])
    np.testing.assert_allclose(found.quaternion_wxyz[0], [0.927362, 0.1, 0.2, 0.3], atol=1e-6)
    np.testing.assert_allclose(found.marker_error, [0.0002, np.nan, 0.0003])
    np.testing.assert_array_equal(found.is_seen, [True, False, True])
    assert take.notes == ()


@pytest.mark.parametrize(
    ("unit", "size"),
    [("Meters", 1), ("METRES", 1), ("Centimeters", 1e-2), ("centimetres", 1e-2), ("Millimeters", 1e-3), ("mm", 1e-3)],
)
def test_units_become_metres(unit, size, write, body, read):
    marker = [("Marker", "m", "M1", "Position", axis) for axis in "XYZ"]
    take = read(write([*body("trunk"), *marker], [[*POSE, 5, 6, 7]], unit=unit))
    np.testing.assert_allclose(take.bodies[0].position[0], np.multiply([1.5, -0.25, 0.125], size))
    np.testing.assert_allclose(take.bodies[0].marker_error[0], 0.0002 * size)
    np.testing.assert_allclose(take.marker("m").position[0], np.multiply([5, 6, 7], size))


@pytest.mark.parametrize("end", ["\r\n", "\n", "\r"])
def test_line_ends_marks_and_blocks_make_no_difference(end, write, body, read, monkeypatch):
    plain = read(write(body("trunk"), [POSE, BLANK, OTHER]))
    for block in (1 << 22, 7, 4):
        monkeypatch.setattr(text_lines, "_BLOCK", block)
        for mark in (b"", b"\xef\xbb\xbf"):
            take = read(mark + write(body("trunk"), [POSE, BLANK, OTHER], end=end))
            np.testing.assert_array_equal(take.bodies[0].position, plain.bodies[0].position)
            assert take.notes == plain.notes


@pytest.mark.parametrize("version", ["1.21", "1.22", "1.23", "1.24"])
def test_versions_give_the_same(version, write, body, marker, read):
    columns, rows = [*body("trunk"), *marker("trunk:1", kind="Rigid Body Marker")], [[*POSE, 1, 2, 3]]
    data = write(columns, rows, version=version, labels=version != "1.21", code=version == "1.24")
    if version == "1.21":
        data = data.replace(b"Mean Marker Error", b"Error Per Marker").replace(b"Take Notes,,", b"")
    take = read(data)
    np.testing.assert_allclose(take.body("trunk").position[0], [1.5, -0.25, 0.125])
    np.testing.assert_allclose(take.body("trunk").marker_error, [0.0002])
    assert take.marker("trunk:1").is_solved
    np.testing.assert_allclose(take.marker("trunk:1").position[0], [1, 2, 3])
    assert take.notes == ()


def test_columns_come_in_any_order(write, body, marker, read):
    columns = [*body("a", "1"), *body("b", "2"), *marker("m"), ("Bone", "hip", "3", "Position", "X")]
    row = [*POSE, *OTHER, 7, 8, 9, "left out"]
    straight = read(write(columns, [row]))
    order = np.random.default_rng(3).permutation(len(columns))
    mixed = read(write([columns[i] for i in order], [[row[i] for i in order]]))
    for name in "ab":
        np.testing.assert_array_equal(mixed.body(name).position, straight.body(name).position)
        np.testing.assert_array_equal(mixed.body(name).quaternion_wxyz, straight.body(name).quaternion_wxyz)
    np.testing.assert_array_equal(mixed.marker("m").position, straight.marker("m").position)
    assert straight.notes == mixed.notes == ("1 of type 'bone' skipped",)


def test_names_that_are_there_twice_stay_apart(write, body, marker, read):
    columns = [*body("a", "1"), *body("a", "2"), *marker("m"), *marker("m"), *marker("a", kind="Rigid Body Marker")]
    take = read(write(columns, [[*POSE, *OTHER, 1, 2, 3, 4, 5, 6, 7, 8, 9]]))
    assert [(found.name, found.id) for found in take.bodies] == [("a", "1"), ("a", "2")]
    np.testing.assert_allclose([found.position[0, 0] for found in take.bodies], [1.5, 1.6])
    np.testing.assert_allclose([found.position[0, 0] for found in take.markers], [1, 4, 7])
    for search in (take.body, take.marker):
        with pytest.raises(TakeError, match=r"there 2 times, with the IDs"):
            search("a" if search == take.body else "m")
    with pytest.raises(TakeError, match=r"there is no rigid body 'c'; allowed: 'a', 'a'"):
        take.body("c")


def test_a_frame_far_from_zero_keeps_its_time(write, body, read):
    take = read(write(body("a"), [POSE, OTHER], first=72210))
    np.testing.assert_allclose(take.time, [722.10, 722.11], rtol=1e-12)


def test_frames_that_count_at_the_cameras_rate_are_noticed(write, body, read):
    data = write(body("a"), [POSE, OTHER] * 3, first=100).replace(b"Export Frame Rate,100.0", b"Export Frame Rate,50.0")
    assert "cameras' rate" in read(data).notes[0]
    np.testing.assert_allclose(read(data).time, 1.0 + 0.01 * np.arange(6))


@pytest.mark.parametrize(("axes", "expected"), [
    ("y-up", [1.5, -0.25, 0.125]), ("Z-UP", [1.5, 0.125, 0.25]), ("x-up", [0.25, 1.5, 0.125]),
    ("x,-z,y", [1.5, -0.125, -0.25]), ("x, y, -z", [1.5, -0.25, -0.125]),
])  # fmt: skip
def test_axes_turn_points_and_rotations_alike(axes, expected, write, body, read):
    """A point that the body carries with it goes where the body's turned pose says."""
    take = read(write(body("a"), [POSE]), axes=axes)
    np.testing.assert_allclose(take.bodies[0].position[0], expected)
    file = Rotation.from_quat(POSE[:4]).as_matrix()
    ours = Rotation.from_quat(take.bodies[0].quaternion_wxyz[0, [1, 2, 3, 0]]).as_matrix()
    turn = np.array([np.sign(read(write(body("a"), [[*POSE[:4], *row, 0]]), axes=axes).bodies[0].position[0])
                     for row in np.eye(3)]).T  # fmt: skip
    np.testing.assert_allclose(ours, turn @ file @ turn.T, atol=1e-6)


@pytest.mark.parametrize("axes", ["", "up", "x,y", "x,y,y", "x,y,z,x", "w,x,y", "++x,y,z", "y-up\0"])
def test_axes_that_are_none_are_refused(axes, write, body, read):
    with pytest.raises(TakeError, match="allowed: y-up, z-up, x-up"):
        read(write(body("a"), [POSE]), axes=axes)


@pytest.mark.parametrize("rotation", ["XYZ", "ZYX", "YZX"])
def test_euler_angles_are_answered(rotation, write, body, marker, read):
    data = write([*body("a", quaternion="XYZ"), *marker("m")], [[10, 20, 30, 1, 2, 3, 0.1, 4, 5, 6]], rotation=rotation)
    error = refuse(read, data)
    assert f"Rotation Type: {rotation}" in str(error)
    assert "export with Rotation: Quaternion" in str(error)
    assert (error.line, error.column) == (7, 3)
    take = read(data, rotations="ignore")
    assert np.isnan(take.bodies[0].quaternion_wxyz).all()
    np.testing.assert_allclose(take.bodies[0].position[0], [1, 2, 3])
    np.testing.assert_allclose(take.marker("m").position[0], [4, 5, 6])


def test_a_header_that_contradicts_the_columns_is_refused(write, body, read):
    data = write(body("a"), [POSE], rotation="XYZ")
    error = refuse(read, data)
    assert "have columns X, Y, Z, W, and the header says Rotation Type: XYZ; allowed: Quaternion" in str(error)
    assert read(data, rotations="ignore").bodies[0].is_seen.all()


@pytest.mark.parametrize("cell", ["nan", "NaN", "-nan"])
def test_what_is_written_as_no_number_is_refused_and_not_taken_as_blank(cell, write, body, read):
    error = refuse(read, write(body("a"), [POSE, [*POSE[:6], cell, *POSE[7:]], POSE]))
    assert f"the cell is '{cell}'; allowed: a number with a decimal point, or a blank cell" in str(error)
    assert (error.line, error.column) == (9, 9)


def test_a_body_without_rotation_is_read(write, body, read):
    take = read(write(body("a")[4:], [POSE[4:]]))
    assert np.isnan(take.bodies[0].quaternion_wxyz).all()
    assert take.bodies[0].is_seen.all()


def test_held_poses_are_stale_and_still_ones_with_noise_are_not(write, body, read):
    still = [[*POSE[:4], 1.5 + 1e-6 * i, -0.25, 0.125, 0.0001] for i in range(4)]
    take = read(write(body("a"), [OTHER, POSE, [*POSE[:7], 0.1], [*POSE[:7], 0.2], POSE, *still[1:]]))
    np.testing.assert_array_equal(take.bodies[0].is_stale, [False, False, True, True, True, False, False, False])
    np.testing.assert_array_equal(take.bodies[0].is_seen, ~take.bodies[0].is_stale)
    assert "'a' the most: 3 of 8 frames" in take.notes[0]


@given(st.lists(st.integers(0, 2), max_size=40))
def test_stale_frames_are_all_but_the_first_of_runs_of_three(values):
    runs = re.finditer(r"(.)\1*", "".join(map(str, values)))
    expected = [k > 0 and len(run[0]) >= 3 for run in runs for k in range(len(run[0]))]
    np.testing.assert_array_equal(find_stale(np.array(values, float).reshape(-1, 1)), np.array(expected, bool))


def test_occlusions_are_not_stale(write, body, read):
    assert not read(write(body("a"), [POSE, BLANK, BLANK, BLANK, BLANK])).bodies[0].is_stale.any()


def test_a_pose_that_is_half_there_or_of_zeros_is_no_pose(write, body, read):
    half, zeros = [*POSE[:4], "", "", "", ""], [0, 0, 0, 0, 1, 2, 3, 0]
    take = read(write(body("a"), [POSE, half, zeros]))
    np.testing.assert_array_equal(take.bodies[0].is_seen, [True, False, False])
    assert "2 poses with blank cells" in take.notes[0]


def test_a_quaternion_that_is_nearly_one_is_made_one_with_a_note(write, body, read):
    take = read(write(body("a"), [POSE, [*POSE[:3], 0.96, *POSE[4:]]]))
    np.testing.assert_allclose(np.linalg.norm(take.bodies[0].quaternion_wxyz, axis=1), 1.0, rtol=1e-12)
    assert take.notes == ("rigid body 'a': 1 quaternions are brought to the length 1",)


def test_quoted_cells_and_blank_ends_are_read(write, body, read):
    plain = write(body("a"), [POSE, OTHER])
    quoted = plain.replace(b"1.5,-0.25", b'"1.5"," -0.25 "').replace(b"0.0002\r\n", b"0.0002,,,\r\n")
    assert quoted.count(b'"1.5"') == 1
    np.testing.assert_array_equal(read(quoted).bodies[0].position, read(plain).bodies[0].position)
    assert len(read(plain + b"\r\n\r\n,,,,\r\n").frame) == 2


def test_notes_with_commas_quotes_and_line_ends_are_skipped(write, body, read):
    data = write(body("a"), [POSE]).replace(b"Take Notes,,", b'Take Notes,"one, ""two""\nLength Units,three",')
    assert read(data).rate == 100.0


def test_a_cut_end_is_left_out_with_a_note(write, body, read):
    data = write(body("a"), [POSE, OTHER, POSE])
    for cut in (3, 30):
        take = read(data[:-cut])
        assert len(take.frame) == 2
        assert any("last row is left out" in note and "line 10" in note for note in take.notes)
        assert "the header says 3 frames, the file has 2" in take.notes
    assert len(read(data[:-30] + b"\r\n").frame) == 2
    assert refuse(read, data[:-30] + b"\r\n" + data.split(b"\r\n")[-2] + b"\r\n").line == 10


def test_wrong_counts_and_missing_frames_are_noted(write, body, read):
    data = write(body("a"), [POSE, OTHER, POSE, OTHER]).replace(
        b"Total Exported Frames,4", b"Total Exported Frames,190951"
    )
    lines_ = data.split(b"\r\n")
    del lines_[9]
    notes = read(b"\r\n".join(lines_)).notes
    assert "the header says 190951 frames, the file has 3" in notes
    assert "frame numbers missing between 0 and 3: 1" in notes


FAULTS = {
    "a word": (b"1.5,", b"one,", "'one'", 8, 7),
    "a decimal comma": (b"1.5,", b'"1,5",', "English number formats", 8, 7),
    "decimal commas": (b"0.1,0.2,0.3,0.927362,1.5,-0.25", b"0,1,0,2,0,3,0,927362,1,5,-0,25", "commas", 8, None),
    "infinite": (b"1.5,", b"inf,", "infinite", 8, 7),
    "too large": (b"1.5,", b"1e400,", "infinite", 8, 7),
    "far away": (b"1.5,", b"1e30,", "at most 10000 m", 8, 7),
    "an underscore": (b"1.5,", b"1_5,", "'1_5'", 8, 7),
    "other digits": (b"1.5,", "\u0661,".encode(), "decimal point", 8, 7),
    "a broken quaternion": (b"0.927362", b"0.5", "length 0.62", 8, 3),
    "a frame that goes back": (b"\r\n1,", b"\r\n0,", "increasing", 9, 1),
    "a frame that is no number": (b"\r\n1,", b"\r\n,", "a whole number", 9, 1),
    "a frame and a half": (b"\r\n1,", b"\r\n1.5,", "a whole number", 9, 1),
    "a cell too many": (b"1.5,", b"1.5,9,", "11 cells, the header 10 columns", 8, None),
    "inches": (b"Meters", b"Inches", "'Inches'", 1, None),
    "no unit": (b"Length Units,Meters,", b"", "Meters, Centimeters or Millimeters", 1, None),
    "local": (b"Global", b"Local", "Global", 1, None),
    "another version": (b"1.23", b"2.0", "1.21 to 1.24", 1, 2),
    "no rate": (b"100.000000,Export Frame Rate,100.000000", b"fast,Export Frame Rate,-1", "a number of Hz", 1, None),
    "no header": (b"Format Version,1.23", b"0,0.000,0.1", "Header information", 1, None),
    "semicolons": (b"Format Version,1.23", b"Format Version;1.23", "semicolons", 1, None),
    "another file": (b"Format Version,1.23", b"hello", "'hello'", 1, None),
    "no axes": (b"Frame,Time", b"Frames,Time", "begins with Frame", 10, None),
    "a missing Y": (b"Z,W,X,Y,Z,", b"Z,W,X,,Z,", "no Position Y", 7, 3),
    "UTF-16": (b"Format", b"\xff\xfeF\0o\0", "UTF-16", None, None),
}  # fmt: skip


@pytest.mark.parametrize("fault", FAULTS)
def test_faults_are_told_with_their_place(fault, write, body, read):
    old, new, told, line, column = FAULTS[fault]
    data = write(body("a"), [POSE, OTHER, POSE])
    assert old in data
    error = refuse(read, data.replace(old, new, 1))
    assert told in str(error)
    assert (error.line, error.column) == (line, column)


@pytest.mark.parametrize(
    "data", [b"", b"\r\n", b"\n\n\n", b"\0", b",", b'"', b"Format Version", b"Format Version,1.23"]
)
def test_next_to_nothing_is_refused(data, read):
    assert "allowed:" in str(refuse(read, data))


def test_a_file_without_data_is_refused(write, body, marker, read):
    assert "no rows of data" in str(refuse(read, write(body("a"), [])))
    assert "no rows of data" in str(refuse(read, write(body("a"), [POSE])[:-5]))
    bone = [("Bone", "hip", "1", "Position", axis) for axis in "XYZ"]
    assert "no position of a rigid body or marker" in str(refuse(read, write(bone, [[1, 2, 3]])))
    error = [("Rigid Body", "a", "1", "Mean Marker Error", "")]
    assert "no position of a rigid body or marker" in str(refuse(read, write(error, [[1]])))


def test_sizes_are_limited(write, body, read, monkeypatch, tmp_path):
    data = write(body("a"), [POSE, OTHER, POSE])
    monkeypatch.setattr(motive_cells, "MOST_CELLS", 20)
    assert "more than 20 numbers" in str(refuse(read, data))
    with monkeypatch.context() as patch:
        patch.setattr(motive_header, "MOST_COLUMNS", 5)
        assert "at most 5" in str(refuse(read, data))
    with monkeypatch.context() as patch:
        patch.setattr(text_lines, "_LONGEST", 100)
        assert "more than 100 bytes" in str(refuse(read, data[:250]))
    path = tmp_path / "take.csv"
    path.write_bytes(data)
    monkeypatch.setattr(text_lines, "MOST_BYTES", 10)
    with pytest.raises(TakeError, match="export in parts"):
        load_motive(path, axes="y-up")


@pytest.mark.parametrize("path", ["missing.csv", ".", "/dev/zero", "a\0b", "x" * 5000])
def test_what_is_no_file_is_refused(path, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(TakeError):
        load_motive(path, axes="y-up")


def test_an_unclosed_quote_does_not_take_in_the_file(write, body, read):
    data = write(body("a"), [POSE] * 2000).replace(b"Take Notes,,", b'Take Notes,"')
    error = refuse(read, data)
    assert error.line is not None


coordinates = st.floats(-9.0, 9.0).map(lambda value: round(value, 6))


@st.composite
def takes(draw):
    count = draw(st.integers(1, 5))
    frame = np.cumsum(draw(st.lists(st.integers(1, 3), min_size=count, max_size=count)))

    def track(width):
        values = np.array(draw(st.lists(coordinates, min_size=width * count, max_size=width * count)))
        hidden = np.array(draw(st.lists(st.booleans(), min_size=count, max_size=count)), bool)
        values = values.reshape(count, width)
        values[hidden] = np.nan
        return values

    names = st.text("abc_ :,\"'\u00e9;", min_size=1, max_size=8).map(str.strip).filter(bool)
    bodies = []
    for number in range(draw(st.integers(0, 2))):
        position = track(3)
        turn = Rotation.random(count, random_state=number).as_quat()[:, [3, 0, 1, 2]]
        turn[np.isnan(position[:, 0])] = np.nan
        bodies.append(Body(
            name=draw(names), id=str(number), position=position, quaternion_wxyz=turn,
            marker_error=np.abs(position[:, 0]),
        ))  # fmt: skip
    markers = [
        Marker(name=draw(names), id=f"m{number}", is_solved=draw(st.booleans()), position=track(3))
        for number in range(draw(st.integers(0 if bodies else 1, 2)))
    ]  # fmt: skip
    return Take(
        source="x", name="t", started="now", rate=100.0, frame=frame, time=frame / 100.0, bodies=tuple(bodies),
        markers=tuple(markers),
    )  # fmt: skip


@given(takes())
@settings(max_examples=60)
def test_what_is_written_is_read(take):
    if all(np.isnan(track.position).all() for track in (*take.bodies, *take.markers)):
        return
    found = read_motive(io.BytesIO(format_motive(take)), source="x", axes="y-up")
    np.testing.assert_array_equal(found.frame, take.frame)
    np.testing.assert_allclose(found.time, take.time, rtol=1e-12)
    assert [(b.name, b.id) for b in found.bodies] == [(b.name, b.id) for b in take.bodies]
    for ours, theirs in zip(found.bodies, take.bodies, strict=True):
        np.testing.assert_allclose(ours.position, theirs.position, atol=6e-7)
        np.testing.assert_allclose(ours.quaternion_wxyz, theirs.quaternion_wxyz, atol=2e-6)
    for ours, theirs in zip(found.markers, take.markers, strict=True):
        assert (ours.name, ours.is_solved) == (theirs.name, theirs.is_solved)
        np.testing.assert_allclose(ours.position, theirs.position, atol=6e-7)


def test_a_failed_write_leaves_nothing(tmp_path, write, body, read, monkeypatch):
    take = read(write(body("a"), [POSE]))
    path = write_motive(take, tmp_path / "take.csv")
    old = path.read_bytes()
    with pytest.raises(TypeError):
        write_motive(replace(take, frame=np.array([None])), path)
    assert [file.read_bytes() for file in tmp_path.iterdir()] == [old]
