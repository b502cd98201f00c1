"""Poses in a file: written whole, read with distrust."""

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from spiraltrunk.errors import DesignError, DriveError, OutputError, SpiralTrunkError, UnknownName
from spiraltrunk.hardware.setup.poses import FORMAT, Pose, PullLimits, check_pose, find_pose, load_poses, write_poses

LIMITS = PullLimits((-0.02, -0.02, -0.02), (0.08, 0.08, 0.08))
POSES = {"curled": Pose("curled", (0.06, -0.01, -0.01)), "été": Pose("été", (0.0, 0.0, 0.0))}


def test_there_and_back(tmp_path):
    path = tmp_path / "poses.json"
    write_poses(path, POSES)
    found = load_poses(path, LIMITS)
    assert list(found) == list(POSES)
    for name, pose in POSES.items():
        assert found[name].pulls == pytest.approx(pose.pulls, abs=1e-15)
    assert json.loads(path.read_text(encoding="utf-8"))["poses"]["curled"]["pulls_mm"] == pytest.approx([60, -10, -10])


def test_no_file_is_no_poses(tmp_path):
    assert load_poses(tmp_path / "poses.json", LIMITS) == {}


def test_a_name_that_is_unknown():
    assert find_pose(POSES, "curled").pulls[0] == 0.06
    with pytest.raises(UnknownName, match="unknown pose 'open'; known: curled, été"):
        find_pose(POSES, "open")


def _file(poses):
    return json.dumps({"format": FORMAT, "poses": poses})


@pytest.mark.parametrize(
    ("content", "text"),
    [
        ("", "no JSON"),
        ("[1]", "allowed: a table of 'format'"),
        ('{"format": "other", "poses": {}}', "allowed: a table of 'format'"),
        (_file([]), "allowed: a table of poses by name"),
        (_file({"a": [1]}), "a list of numbers"),
        (_file({"a": {"pulls_mm": [1, 2, True]}}), "a list of numbers"),
        (_file({"a": {"pulls_mm": [1, 2, "3"]}}), "a list of numbers"),
        (_file({"a": {"pulls_mm": [1, 2, 3], "more": 1}}), "a list of numbers"),
        (_file({"a": {"pulls_mm": [1, 2]}}), "has 2 pulls; allowed: 3"),
        (_file({"a": {"pulls_mm": [1, 400, 3]}}), r"pull of cable 2 is 400 mm; allowed: -20 to 80 mm"),
        (_file({"a": {"pulls_mm": [1, float("nan"), 3]}}), "holds NaN"),
        (_file({"a": {"pulls_mm": [1, 10**400, 3]}}), "numbers"),
        (_file({"": {"pulls_mm": [1, 2, 3]}}), "name of a pose"),
        (_file({"a\nb": {"pulls_mm": [1, 2, 3]}}), "name of a pose"),
        ('{"format": "x", "poses": {"a": 1, "a": 2}}', "the name 'a' stands twice"),
        ("[" * 100_000, "no JSON"),
        ("\x00" * 1_000_001, "larger than 1 MB"),
    ],
)
def test_bad_files(tmp_path, content, text):
    path = tmp_path / "poses.json"
    path.write_text(content)
    with pytest.raises(DriveError, match=text) as refused:
        load_poses(path, LIMITS)
    assert "poses.json" in str(refused.value)
    assert "\n" not in str(refused.value)


def test_bytes_that_are_no_text(tmp_path):
    path = tmp_path / "poses.json"
    path.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(DriveError, match="no JSON"):
        load_poses(path, LIMITS)


@given(st.binary(max_size=200))
def test_any_bytes_are_refused_in_words(tmp_path_factory, data):
    path = tmp_path_factory.mktemp("poses") / "poses.json"
    path.write_bytes(data)
    with pytest.raises(DriveError):
        load_poses(path, LIMITS)


def test_a_file_of_something_else_is_kept(tmp_path):
    path = tmp_path / "trunk.toml"
    path.write_text("b = 0.2\n")
    with pytest.raises(OutputError, match="is kept: it holds no poses"):
        write_poses(path, POSES)
    assert path.read_text() == "b = 0.2\n"


def test_a_folder_cannot_be_written(tmp_path):
    with pytest.raises(OutputError):
        write_poses(tmp_path, POSES)
    with pytest.raises(DriveError, match="cannot be read"):
        load_poses(tmp_path, LIMITS)


def test_a_pose_that_does_not_fit_the_design():
    with pytest.raises(DriveError, match=r"pull of cable 1 is 90 mm; allowed: -20 to 80 mm"):
        check_pose(Pose("far", (0.09, 0.0, 0.0)), LIMITS)
    for pulls in ((float("nan"), 0.0, 0.0), [0.0], (20.0,)):
        with pytest.raises(DesignError):
            Pose("bad", pulls)
    assert issubclass(DesignError, SpiralTrunkError)
