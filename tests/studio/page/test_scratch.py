"""Temporary folders of a server."""

import signal
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

from spiraltrunk.studio.page import scratch

SERVER = """
import sys, tempfile, time
tempfile.tempdir = sys.argv[1]
from spiraltrunk.studio.page.scratch import make_scratch
print(make_scratch("parts"), flush=True)
time.sleep(600 if sys.argv[2] == "stays" else 0)
"""


@pytest.fixture
def own_root(tmp_path, monkeypatch):
    """This process has no folder yet, and makes it in ``tmp_path``."""
    monkeypatch.setattr(scratch, "_roots", [])
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))


def start(place, ending):
    """A server's process, and its folder."""
    one = subprocess.Popen([sys.executable, "-c", SERVER, str(place), ending], stdout=subprocess.PIPE, text=True)
    return one, Path(one.stdout.readline().strip())


def test_a_server_that_ends_removes_its_folder(tmp_path):
    one, folder = start(tmp_path, "ends")
    one.communicate()
    assert folder.name.startswith("parts-")
    assert list(tmp_path.iterdir()) == []


def test_the_folder_of_a_killed_server_is_removed_and_that_of_a_living_one_stays(tmp_path, own_root):
    killed, left = start(tmp_path, "stays")
    living, kept = start(tmp_path, "stays")
    try:
        killed.send_signal(signal.SIGKILL)
        killed.communicate()
        assert left.is_dir()
        mine = scratch.make_scratch("job")
        assert mine.is_dir()
        assert not left.parent.exists()
        assert kept.is_dir()
    finally:
        living.kill()
        living.communicate()


def test_a_full_disc_is_told(tmp_path, own_root, monkeypatch):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "missing"))
    with pytest.raises(OSError, match="missing"):
        scratch.make_scratch("job")
