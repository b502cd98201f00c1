"""Standard error that is closed or full ends no command, and names that are no UTF-8 are printed."""

from __future__ import annotations

import errno
import io
import os
import pathlib
import subprocess
import sys
import time

import pytest

from spiraltrunk import cli
from spiraltrunk.cli import progress as progress_module
from spiraltrunk.cli.output import put
from spiraltrunk.cli.progress import print_if_slow, show_progress
from spiraltrunk.cli.verbs import design
from spiraltrunk.cli.verbs.survey.progress import show_survey

ROW = {"strategy": "kick", "object": "box-60", "seed": 1, "success": True, "reason": ""}


def open_broken():
    """A stream whose reader is gone."""
    reading, writing = os.pipe()
    os.close(reading)
    return io.TextIOWrapper(os.fdopen(writing, "wb", buffering=0), write_through=True)


@pytest.mark.parametrize("stream", [None, "broken", "/dev/full"])
def test_progress_that_nobody_reads_is_left_out(stream: str | None) -> None:
    for kind in ("steps", "survey"):
        opened = None if stream is None else open_broken() if stream == "broken" else pathlib.Path(stream).open("w")  # noqa: SIM115
        if kind == "steps":
            with show_progress(opened) as progress:
                progress("reading", 0, 1)
                progress("report", 0, 1)
        else:
            with show_survey(opened, {"kick": 2}) as watch:
                watch([])
                watch([ROW])
        assert opened is None or not opened.closed


def test_progress_is_a_line_a_step() -> None:
    stream = io.StringIO()
    with show_progress(stream) as progress:
        for step in ("reading", "reading", "report"):
            progress(step, 0, 1)
    with show_survey(stream, {"kick": 2}) as watch:
        watch([])
        watch([ROW])
    assert stream.getvalue().splitlines() == [
        "spiraltrunk: reading", "spiraltrunk: report", "spiraltrunk: 0/2 trials",
        "spiraltrunk: 1/2 kick, box-60, seed 1:  (1 of 1 succeeded)",
    ]  # fmt: skip


@pytest.mark.parametrize("arguments", [["design", "--json"], ["--help"], ["drive", "--help"], ["--version"]])
def test_a_reader_that_is_gone_is_no_error(arguments: list[str]) -> None:
    reading, writing = os.pipe()
    os.close(reading)
    command = [sys.executable, "-m", "spiraltrunk", *arguments]
    ran = subprocess.run(command, stdout=writing, stderr=subprocess.PIPE, text=True, check=False)
    os.close(writing)
    assert (ran.returncode, ran.stderr) == (0, "")


@pytest.mark.parametrize(
    ("error", "code", "told"),
    [
        (BrokenPipeError(errno.EPIPE, "Broken pipe"), 1, "Broken pipe: a process, connection or resource"),
        (ConnectionRefusedError(errno.ECONNREFUSED, "Connection refused"), 1, "Connection refused: a process,"),
        (OSError(errno.EMFILE, "Too many open files"), 1, "Too many open files: a process, connection or resource"),
        (TimeoutError(), 1, "TimeoutError: a process,"),
        (OSError(errno.ENOSPC, "No space left on device"), 2, "cannot write: No space left on device"),
        (OSError(errno.EACCES, "Permission denied", "x"), 2, "'x': Permission denied; allowed: a file or folder"),
    ],
)
def test_what_breaks_inside_a_verb_is_told(
    error: OSError, code: int, told: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def fail(_: object) -> None:
        raise error

    monkeypatch.setattr(design, "_run", fail)
    assert cli.main(["design"]) == code
    printed = capsys.readouterr()
    assert printed.out == ""
    assert printed.err.startswith(f"spiraltrunk: error: {told}")


@pytest.mark.parametrize(("encoding", "printed"), [("utf-8", "räum a\\udcff"), ("ascii", "r\\xe4um a\\udcff")])
def test_names_that_the_stream_cannot_hold_are_escaped(
    encoding: str, printed: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    raw = io.BytesIO()
    monkeypatch.setattr(sys, "stdout", io.TextIOWrapper(raw, encoding=encoding))
    assert put(0, "räum a\udcff") == 0
    assert raw.getvalue().decode() == f"{printed}\n"


def test_only_what_takes_long_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    stream = io.StringIO()
    monkeypatch.setattr(progress_module, "SLOW", 0.5)
    with print_if_slow("thinking", stream):
        pass
    time.sleep(1.0)
    assert not stream.getvalue()
    with print_if_slow("thinking long", stream):
        end = time.monotonic() + 30.0
        while not stream.getvalue() and time.monotonic() < end:
            time.sleep(0.01)
    assert stream.getvalue() == "spiraltrunk: thinking long ...\n"
