"""Jobs in processes: what fails costs its job alone, and nothing stays behind."""

from __future__ import annotations

import multiprocessing
import signal
import subprocess
import sys
import time
from contextlib import closing
from types import ModuleType

import pytest

from spiraltrunk.errors import RunError
from spiraltrunk.workflows.survey.plan import Entry
from spiraltrunk.workflows.survey.process_pool import run_jobs


def entries(count: int) -> list[Entry]:
    return [Entry(strategy="kick", object="box-60", index=i, seed=i) for i in range(count)]


@pytest.mark.parametrize("workers", [1, 3])
def test_every_job_is_done_once(fakes: ModuleType, workers: int) -> None:
    outcomes = list(run_jobs(fakes.double, range(10), workers))
    assert sorted((outcome.job, outcome.result, outcome.fault) for outcome in outcomes) == [
        (i, 2 * i, None) for i in range(10)
    ]
    assert multiprocessing.active_children() == []


def test_no_jobs_need_no_process(fakes: ModuleType) -> None:
    assert list(run_jobs(fakes.double, [], 4)) == []


@pytest.mark.parametrize(
    ("work", "fault"),
    [("raise_second", "ValueError: no plan for seed 1"), ("die_second", "its process died (SIGKILL)")],
)
def test_a_job_that_fails_fails_alone(fakes: ModuleType, work: str, fault: str) -> None:
    outcomes = {outcome.job.index: outcome for outcome in run_jobs(getattr(fakes, work), entries(4), 2)}
    assert sorted(outcomes) == [0, 1, 2, 3]
    assert (outcomes[1].result, outcomes[1].fault) == (None, fault)
    assert all(outcomes[i].result["success"] for i in (0, 2, 3))


def test_processes_that_cannot_start_are_not_tried_for_every_job(fakes: ModuleType) -> None:
    with pytest.raises(RunError, match=r"before its first trial \(exit code 3\)"):
        list(run_jobs(fakes.Unreadable(), range(1000), 2))
    assert multiprocessing.active_children() == []


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
    began = time.monotonic()
    with closing(run_jobs(fakes.hang_after_third, entries(8), 2)) as outcomes:
        assert sorted(next(outcomes).job.index for _ in range(3)) == [0, 1, 2]
    assert time.monotonic() - began < 20
    assert multiprocessing.active_children() == []


def test_the_pool_itself_is_light() -> None:
    """A process sets its threads before a library reads them."""
    program = "import sys, spiraltrunk.workflows.survey.process_pool; print('numpy' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", program], capture_output=True, check=True).stdout == b"False\n"
