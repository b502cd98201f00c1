"""A file is replaced as a whole or not at all, and what a killed process leaves is removed by the next."""

from __future__ import annotations

import errno
import fcntl
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from spiraltrunk.files import lock
from spiraltrunk.files.atomic import atomic_file, write_file, write_text

KILLED = """
import os, signal, sys
from spiraltrunk.files.atomic import atomic_file
with atomic_file(sys.argv[1]) as draft:
    draft.write_text("half")
    os.kill(os.getpid(), signal.SIGKILL)
"""


def test_the_draft_of_a_killed_process_is_removed_and_that_of_a_living_one_stays(tmp_path: Path) -> None:
    path = tmp_path / "a.txt"
    ran = subprocess.run([sys.executable, "-c", KILLED, str(path)], check=False)
    assert ran.returncode == -signal.SIGKILL
    assert len(list(tmp_path.iterdir())) == 1
    with atomic_file(path) as draft:
        assert list(tmp_path.iterdir()) == [draft]
        write_file(path, b"another's")
        assert set(tmp_path.iterdir()) == {draft, path}
        draft.write_text("mine")
    assert {each.name: each.read_text() for each in tmp_path.iterdir()} == {"a.txt": "mine"}


def test_drafts_of_other_files_stay(tmp_path: Path) -> None:
    subprocess.run([sys.executable, "-c", KILLED, str(tmp_path / "a.txt")], check=False)
    write_file(tmp_path / "b.txt", b"b")
    assert len(list(tmp_path.iterdir())) == 2


def test_a_draft_that_another_process_removes_before_it_is_locked_is_made_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    opened, others = os.open, []

    def interrupt(path: Path, *arguments: int) -> int:
        descriptor = opened(path, *arguments)
        if len(others) < 3:
            others.append(opened(path, os.O_RDWR))
            fcntl.flock(others[-1], fcntl.LOCK_EX | fcntl.LOCK_NB)
            path.unlink()
        return descriptor

    monkeypatch.setattr(lock.os, "open", interrupt)
    with atomic_file(tmp_path / "a.txt") as draft:
        assert list(tmp_path.iterdir()) == [draft]
        draft.write_text("whole")
    for other in others:
        os.close(other)
    assert len(others) == 3
    assert {each.name: each.read_text() for each in tmp_path.iterdir()} == {"a.txt": "whole"}


def test_a_draft_that_can_never_be_locked_is_an_error_of_the_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(descriptor: int, operation: int) -> None:
        raise BlockingIOError(errno.EAGAIN, os.strerror(errno.EAGAIN))

    monkeypatch.setattr(fcntl, "flock", refuse)
    with pytest.raises(BlockingIOError) as caught:
        write_file(tmp_path / "a.txt", b"a")
    assert caught.value.filename == str(tmp_path / "a.txt")


def test_a_full_disc_is_told_with_the_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fill(number: int) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "fsync", fill)
    with pytest.raises(OSError, match="No space left") as caught:
        write_file(tmp_path / "new" / "a.txt", b"a")
    assert caught.value.filename == str(tmp_path / "new" / "a.txt")
    assert list(tmp_path.iterdir()) == []


def test_an_error_of_another_file_keeps_its_name(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError) as caught, atomic_file(tmp_path / "a.txt"):
        (tmp_path / "source.txt").read_text()
    assert caught.value.filename == str(tmp_path / "source.txt")


def test_names_of_files_that_are_no_utf_8_are_escaped(tmp_path: Path) -> None:
    write_text(tmp_path / "a.txt", "räum a\udcff")
    assert (tmp_path / "a.txt").read_bytes() == "räum a\\udcff".encode()
