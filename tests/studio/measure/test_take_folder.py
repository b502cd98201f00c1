"""Recordings of a page."""

import pytest

from spiraltrunk.errors import TakeError
from spiraltrunk.studio.measure import take_folder
from spiraltrunk.studio.measure.take_folder import TakeFolder, find_folder, keep_folder


@pytest.fixture
def folder():
    folder = TakeFolder()
    yield folder
    folder.close()


def test_a_take_is_kept_under_a_name_of_our_own(folder):
    take = folder.add("bend-dorsal_../../etc/passwd.csv", b"x", "twist")
    assert take.file == str(folder.folder / "upload_1.csv")
    assert [one.name for one in folder.folder.iterdir()] == ["upload_1.csv"]


def test_the_run_is_that_of_the_name_or_the_chosen_one(folder):
    assert folder.add("Bend-Dorsal_3.CSV", b"x", None).run == "bend-dorsal"
    assert folder.add("Bend-Dorsal_4.csv", b"x", "twist").run == "twist"
    assert {run: len(files) for run, files in folder.list_by_run().items()} == {"bend-dorsal": 1, "twist": 1}
    with pytest.raises(TakeError, match="begins with no run's name; choose its run: rest-000"):
        folder.add("take.csv", b"x", None)


def test_what_is_no_recording_is_refused(folder):
    with pytest.raises(TakeError, match=r"a\.pdf' is no recording; allowed: a Motive CSV, or C3D"):
        folder.add("a.pdf", b"x", "twist")


def test_no_more_takes_than_allowed(folder, monkeypatch):
    monkeypatch.setattr(take_folder, "MOST_TAKES", 1)
    folder.add("twist.csv", b"x", None)
    with pytest.raises(TakeError, match="there are 1 takes already"):
        folder.add("twist.csv", b"x", None)


def test_texts_call_files_as_the_person_does(folder):
    take = folder.add("twist_1.csv", b"x", None)
    assert folder.name_files(f"'{take.file}': line 3") == "'twist_1.csv': line 3"


def test_a_protocol_brings_its_runs_and_clears_the_takes(folder):
    folder.add("twist_1.csv", b"x", None)
    folder.set_protocol(b'schema = 1\nname = "mine"\n[[run]]\nname = "hang"\nkind = "rest"\ntilt_deg = 0\n', "a.toml")
    assert [run.name for run in folder.protocol.runs] == ["hang"]
    assert folder.takes == []
    assert folder.add("hang.csv", b"x", None).run == "hang"


def test_a_bad_protocol_changes_nothing(folder):
    folder.add("twist_1.csv", b"x", None)
    with pytest.raises(TakeError, match=r"^'mine.toml': .* protocol in TOML"):
        folder.set_protocol(b"\xff\xfe", "mine.toml")
    assert len(folder.takes) == 1
    assert folder.protocol.name == "paper"


def test_a_reload_finds_the_folder_once_and_old_ones_are_removed(monkeypatch):
    monkeypatch.setattr(take_folder, "_MOST_KEPT", 1)
    first, second = TakeFolder(), TakeFolder()
    assert first.folder.exists()
    assert second.folder.exists()
    keep_folder(first)
    keep_folder(second)
    assert not first.folder.exists()
    assert find_folder(first.name) is None
    assert find_folder(second.name) is second
    assert find_folder(second.name) is None
    second.close()
    assert not second.folder.exists()
