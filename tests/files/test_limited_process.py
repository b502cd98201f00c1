"""A process with limits: its result comes back, and it is over in every other case."""

from __future__ import annotations

import os
import signal
from pathlib import Path

import pytest

from spiraltrunk.files.limited_process import run_limited

TASKS = """
import os, time

def run_double(sent):
    print("not the result")
    return 2 * sent

def run_raise(sent):
    raise ValueError("broken")

def run_sleep(sent):
    time.sleep(600)

def run_count(sent):
    while True:
        pass

def run_take(sent):
    return bytes(1 << 31)

def run_die(sent):
    os.kill(os.getpid(), 11)

def run_nothing(sent):
    return b""
"""


@pytest.fixture
def tasks(tmp_path: Path) -> Path:
    file = tmp_path / "tasks.py"
    file.write_text(TASKS)
    return file


def list_children() -> set[str]:
    """Processes that this one started and that are not over."""
    return set(Path(f"/proc/self/task/{os.getpid()}/children").read_text().split())


def test_the_result_comes_back(tasks: Path) -> None:
    assert run_limited(tasks, "double", b"\0ab", seconds=60, memory=1 << 30) == b"\0ab\0ab"


@pytest.mark.parametrize(
    ("task", "code"), [("raise", "1"), ("take", "1"), ("die", f"-{signal.SIGSEGV:d}"), ("nothing", "0"), ("none", "1")]
)
def test_another_end_is_told(tasks: Path, task: str, code: str) -> None:
    with pytest.raises(ChildProcessError, match=f"^{code}$"):
        run_limited(tasks, task, b"a", seconds=60, memory=1 << 30)


@pytest.mark.parametrize("task", ["sleep", "count"])
def test_what_takes_too_long_is_ended(tasks: Path, task: str) -> None:
    before = list_children()  # Of other tests, such as a browser.
    with pytest.raises((TimeoutError, ChildProcessError)) as caught:
        run_limited(tasks, task, b"a", seconds=1, memory=1 << 30)
    assert isinstance(caught.value, TimeoutError) or str(caught.value) in {
        f"-{signal.SIGXCPU:d}",
        f"-{signal.SIGKILL:d}",
    }
    assert list_children() <= before
