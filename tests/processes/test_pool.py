"""Jobs in processes: what fails costs its job alone, and nothing stays behind."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from contextlib import closing
from pathlib import Path
from types import ModuleType

import pytest

from spiraltrunk.errors import RunError
from spiraltrunk.processes.pool import run_jobs


def list_children() -> list[int]:
    """Processes that this one started and did not yet wait for."""
    tasks = Path("/proc/self/task").glob("*/children")
    return [int(number) for task in tasks for number in task.read_text().split()]


@pytest.fixture(autouse=True)
def no_process_stays() -> object:
    before = list_children()
    yield
    assert list_children() == before


@pytest.mark.parametrize("workers", [1, 3])
def test_every_job_is_done_once(fakes: ModuleType, workers: int) -> None:
    outcomes = list(run_jobs(fakes.double, range(10), workers))
    assert sorted((outcome.job, outcome.unwrap(), outcome.fault) for outcome in outcomes) == [
        (i, 2 * i, None) for i in range(10)
    ]


def test_no_jobs_need_no_process(fakes: ModuleType) -> None:
    assert list(run_jobs(fakes.double, [], 4)) == []


@pytest.mark.parametrize(
    ("work", "fault", "error"),
    [
        ("raise_second", "ValueError: no plan for seed 1", ValueError),
        ("die_second", "its process died (SIGKILL)", RunError),
    ],
)
def test_a_job_that_fails_fails_alone(fakes: ModuleType, work: str, fault: str, error: type[Exception]) -> None:
    outcomes = {outcome.job: outcome for outcome in run_jobs(getattr(fakes, work), range(4), 2)}
    assert sorted(outcomes) == [0, 1, 2, 3]
    assert (outcomes[1].result, outcomes[1].fault) == (None, fault)
    assert all(outcomes[i].unwrap() == i for i in (0, 2, 3))
    with pytest.raises(error):
        outcomes[1].unwrap()


def test_an_exception_that_cannot_be_sent_is_told(fakes: ModuleType) -> None:
    (outcome,) = run_jobs(fakes.raise_unpicklable, ["job"], 1)
    with pytest.raises(RunError, match="UnpicklableError: not to be sent"):
        outcome.unwrap()


def test_processes_that_cannot_start_are_not_tried_for_every_job(fakes: ModuleType) -> None:
    with pytest.raises(RunError, match=r"before its first job \(exit code 3\)"):
        list(run_jobs(fakes.Unreadable(), range(1000), 2))


def test_a_process_has_one_thread_and_no_standard_output(fakes: ModuleType, capfd: pytest.CaptureFixture[str]) -> None:
    names = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "NUMBA_NUM_THREADS")
    assert [outcome.result for outcome in run_jobs(fakes.tell_threads, names, 1)] == ["1", "1", "1"]
    printed = capfd.readouterr()
    assert printed.out == ""
    assert "what a library prints" in printed.err


def test_signals_of_the_terminal_reach_no_process(fakes: ModuleType) -> None:
    assert [outcome.fault for outcome in run_jobs(fakes.shout, [1, 2], 1)] == [None, None]
    assert signal.pthread_sigmask(signal.SIG_BLOCK, ()) == set()


def test_leaving_early_ends_the_processes_at_once(fakes: ModuleType) -> None:
    """Else the jobs would go on for ten minutes, more than a test may take."""
    with closing(run_jobs(fakes.hang_after_third, range(8), 2)) as outcomes:
        assert sorted(next(outcomes).job for _ in range(3)) == [0, 1, 2]


def test_the_pool_itself_is_light() -> None:
    """A process sets its threads before a library reads them."""
    program = "import sys, spiraltrunk.processes.pool; print('numpy' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", program], capture_output=True, check=True).stdout == b"False\n"


IN_MAIN = """
import os, time
from spiraltrunk.processes.pool import run_jobs
def work(job):
    os.write(2, f"working {os.getpid()}\\n".encode())  # At once: the lines of both processes stay whole.
    BUSY
if __name__ == "__main__":
    list(run_jobs(work, [1, 2], 2))
"""
"""A program whose own function is the work."""

BUSY = {
    "waiting": "time.sleep(600)",
    "in a library that keeps Python's lock": "import ctypes; ctypes.PyDLL(None).sleep(600)",
}


@pytest.mark.parametrize("busy", BUSY)
def test_processes_end_with_a_parent_that_is_killed(busy: str, tmp_path: Path) -> None:
    """The end of the pipe that all share is its evidence: `communicate` reads until the last process is gone."""
    (tmp_path / "program.py").write_text(IN_MAIN.replace("BUSY", BUSY[busy]))
    with subprocess.Popen([sys.executable, tmp_path / "program.py"], stderr=subprocess.PIPE, text=True) as parent:
        assert parent.stderr is not None
        told = [parent.stderr.readline() for _ in range(2)]
        parent.kill()
        assert parent.communicate()[1] == ""
    assert [line.split()[0] for line in told] == ["working"] * 2


def test_a_process_whose_parent_dies_as_it_starts_says_nothing() -> None:
    """Its parent sends nothing and is gone, as if killed while it started processes."""
    ours, theirs = os.pipe()
    program = f"from spiraltrunk.processes.worker import serve; serve({ours}, {os.getppid()}, is_main=False)"
    with subprocess.Popen([sys.executable, "-c", program], pass_fds=[ours], stderr=subprocess.PIPE) as process:
        os.close(ours)
        os.close(theirs)
        assert process.communicate()[1] == b""
    assert process.returncode == 0


UNGUARDED = """
import sys
from functools import partial
from spiraltrunk.processes.pool import run_jobs
def double(job):
    return 2 * job
for work in WORK:
    print(sorted(outcome.unwrap() for outcome in run_jobs(work, [1, 2], 2)))
"""
"""A program that starts processes as it is imported."""


@pytest.mark.parametrize(("work", "told"), [("[abs]", "[1, 2]\n"), ("[double]", "")])
def test_a_main_module_is_imported_only_where_it_is_needed_and_never_in_a_circle(
    work: str, told: str, tmp_path: Path
) -> None:
    (tmp_path / "program.py").write_text(UNGUARDED.replace("WORK", work))
    ran = subprocess.run([sys.executable, tmp_path / "program.py"], capture_output=True, text=True, check=False)
    assert ran.stdout == told
    assert ("allowed: where that is guarded by if __name__ == '__main__'" in ran.stderr) == (told == "")
