"""Acts in the page's thread, and work in processes."""

import pathlib
import tempfile
import threading
import time

import pytest

from spiraltrunk.errors import ModelError, RunError
from spiraltrunk.studio.page import job
from spiraltrunk.studio.page.act_queue import ActQueue
from spiraltrunk.studio.page.job import STOPPED, Job, Refusal


def test_of_acts_under_one_key_the_last_runs():
    seen, gate = [], threading.Event()
    queue = ActQueue(lambda act: act())
    queue.put(None, gate.wait)
    for i in range(5):
        queue.put("slider", lambda i=i: seen.append(i))
    queue.put(None, lambda: seen.append("one"))
    queue.put(None, lambda: seen.append("two"))
    done = threading.Event()
    queue.put(None, done.set)
    gate.set()
    assert done.wait(10)
    assert seen == [4, "one", "two"]


def test_closing_drops_what_waits_and_runs_the_last_act():
    seen, gate = [], threading.Event()
    queue = ActQueue(lambda act: act())
    queue.put(None, gate.wait)
    queue.put(None, lambda: seen.append("late"))
    threading.Timer(0.1, gate.set).start()
    queue.close(lambda: seen.append("last"), 10.0)
    queue.put(None, lambda: seen.append("too late"))
    assert seen == ["last"]


def count(report, n):
    for i in range(n):
        report(i)
    return "done"


def refuse(report):
    raise RunError("no object here")


def refuse_input(report):
    raise ModelError("too thin")


def work_for_ever(report):
    report("begun")
    time.sleep(1000)


def leave_files(report):
    report(tempfile.mkdtemp())
    time.sleep(1000)


def end(work, *arguments, stop_at_report=False):
    reports, answers, ended = [], [], threading.Event()
    one = Job(work, arguments)

    def take(report):
        reports.append(report)
        if stop_at_report:
            one.stop()

    def finish(*answer):
        answers.append(answer)
        ended.set()

    one.start(take, finish)
    assert ended.wait(60)
    assert not one.is_running
    return reports, answers


def test_work_reports_and_ends():
    assert end(count, 3) == ([0, 1, 2], [("done", None)])


@pytest.mark.parametrize(("work", "reason"), [(refuse, "no object here"), (count, "TypeError")])
def test_work_that_fails_says_why(work, reason):
    reports, [(result, why)] = end(work)
    assert (reports, result) == ([], None)
    assert reason in why


@pytest.mark.parametrize(("work", "kind"), [(refuse_input, Refusal), (refuse, str), (count, str)])
def test_a_refusal_of_what_was_given_is_told_apart(work, kind):
    _, [(_, why)] = end(work)
    assert type(why) is kind


@pytest.mark.filterwarnings("error::pytest.PytestUnhandledThreadExceptionWarning")
def test_a_listener_that_fails_ends_the_work_with_the_reason():
    answers, ended = [], threading.Event()
    one = Job(count, (3,))

    def fail(report):
        raise ZeroDivisionError("no picture")

    def finish(*answer):
        answers.append(answer)
        ended.set()

    one.start(fail, finish)
    assert ended.wait(60)
    assert answers == [(None, "ZeroDivisionError: no picture")]
    assert not one.is_running


def test_work_can_be_stopped():
    assert end(work_for_ever, stop_at_report=True) == (["begun"], [(None, STOPPED)])


def test_work_that_is_stopped_leaves_no_temporary_files():
    [folder], answers = end(leave_files, stop_at_report=True)
    assert answers == [(None, STOPPED)]
    assert not pathlib.Path(folder).exists()


def test_work_without_a_temporary_folder_says_why(monkeypatch):
    def make(name):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(job, "make_scratch", make)
    reports, [(result, why)] = end(count, 3)
    assert (reports, result) == ([], None)
    assert "No space left on device" in why


def test_work_that_is_stopped_at_once_ends():
    answers, ended = [], threading.Event()
    one = Job(work_for_ever, ())

    def finish(*answer):
        answers.append(answer)
        ended.set()

    one.start(lambda _: None, finish)
    one.stop()
    assert ended.wait(60)
    assert answers == [(None, STOPPED)]
