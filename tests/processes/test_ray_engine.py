"""Jobs on Ray, with a Ray in this process that hands out tasks as it likes."""

from __future__ import annotations

import os
import pickle
import random
import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import pytest

from spiraltrunk.errors import MissingPackage, RunError
from spiraltrunk.processes import ray_engine
from spiraltrunk.processes.pool import THREADS
from spiraltrunk.processes.ray_engine import RayEngine


class FakeRayError(Exception):
    """A task is lost."""


class FakeRay:
    """Runs a task when its result is asked for, in any order."""

    cloudpickle = pickle
    exceptions = SimpleNamespace(RayError=FakeRayError)

    def __init__(self, cpus: int = 2) -> None:
        self.cpus = cpus
        self.is_up = False
        self.asked: dict[str, Any] = {}
        self.token = ""
        self.largest = 0
        self.cancelled: list[Any] = []
        self.lost: set[int] = set()
        self.refusal: Exception | None = None
        self._random = random.Random(0)
        self._tasks: list[tuple[Callable[..., Any], tuple[Any, ...]]] = []

    def is_initialized(self) -> bool:
        return self.is_up

    def init(self, **asked: Any) -> None:
        if self.refusal is not None:
            raise self.refusal
        signal.signal(signal.SIGTERM, lambda number, frame: None)
        print("what Ray prints")
        os.write(1, b"what a library prints\n")
        self.asked, self.is_up = asked, True
        self.token = os.environ.get("RAY_AUTH_TOKEN", "")

    def shutdown(self) -> None:
        self.is_up = False

    def cluster_resources(self) -> dict[str, float]:
        return {"CPU": float(self.cpus)} if self.cpus else {}

    def remote(self, **asked: Any) -> Callable[[Callable[..., Any]], Any]:
        assert asked == {"num_cpus": 1, "max_retries": ray_engine.RETRIES}
        return lambda function: SimpleNamespace(remote=lambda *given: self._submit(function, given))

    def _submit(self, function: Callable[..., Any], given: tuple[Any, ...]) -> int:
        self._tasks.append((function, given))
        return len(self._tasks)

    def wait(self, pending: list[Any], *, num_returns: int, timeout: float) -> tuple[list[Any], list[Any]]:
        assert (num_returns, timeout > 0) == (1, True)
        self.largest = max(self.largest, len(pending))
        done = self._random.choice(pending)
        return [done], [each for each in pending if each is not done]

    def get(self, number: int) -> Any:
        function, given = self._tasks[number - 1]
        if number in self.lost:
            raise FakeRayError
        return pickle.loads(pickle.dumps(function(*given)))

    def cancel(self, number: int, *, force: bool) -> None:
        self.cancelled.append(number)


@pytest.fixture
def ray(monkeypatch: pytest.MonkeyPatch) -> Iterator[FakeRay]:
    for name in THREADS:
        monkeypatch.setenv(name, "1")
    monkeypatch.setattr(sys, "path", list(sys.path))
    fake = FakeRay()
    monkeypatch.setattr(ray_engine, "load_ray", lambda: fake)
    yield fake
    assert not fake.is_up


def test_every_job_is_done_once_with_few_pending(fakes: ModuleType, ray: FakeRay) -> None:
    outcomes = list(RayEngine()(fakes.double, range(20), 2))
    assert sorted((outcome.job, outcome.unwrap()) for outcome in outcomes) == [(i, 2 * i) for i in range(20)]
    assert ray.largest == 4


def test_relative_paths_count_from_the_folder_of_the_command(
    ray: FakeRay, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    begun, other = tmp_path / "begun", tmp_path / "other"
    for folder in (begun, other):
        folder.mkdir()
    (begun / "part.stl").write_text("solid")
    monkeypatch.chdir(begun)

    def jobs() -> Iterator[str]:
        monkeypatch.chdir(other)  # Where the worker was started.
        yield "part.stl"

    outcomes = list(RayEngine()(os.path.getsize, jobs(), 1))
    assert [outcome.unwrap() for outcome in outcomes] == [5]


def test_a_ray_of_this_machine_is_light_and_leaves_nothing(fakes: ModuleType, ray: FakeRay) -> None:
    assert list(RayEngine()(fakes.double, [], 3)) == []
    folder = ray.asked.pop("_temp_dir")
    assert not os.path.lexists(folder)
    assert len(ray.token) == 64, "else Ray writes a token of its own"
    assert "RAY_AUTH_TOKEN" not in os.environ
    assert ray.asked.pop("object_store_memory") <= 128 * 2**20
    assert ray.asked == {
        "address": "local", "num_cpus": 3, "include_dashboard": False, "log_to_driver": False,
        "logging_level": "ERROR",
    }  # fmt: skip


def test_a_cluster_keeps_its_own_size(fakes: ModuleType, ray: FakeRay) -> None:
    ray.cpus = 5
    list(RayEngine(address="10.0.0.1:6379")(fakes.double, range(30), 2))
    assert (ray.asked["address"], "num_cpus" in ray.asked, ray.largest) == ("10.0.0.1:6379", False, 10)
    assert ray.token == "", "a cluster has its own"


def test_a_job_that_raises_fails_alone(fakes: ModuleType, ray: FakeRay) -> None:
    outcomes = {outcome.job: outcome for outcome in RayEngine()(fakes.raise_second, range(4), 2)}
    assert outcomes[1].fault == "ValueError: no plan for seed 1"
    assert isinstance(outcomes[1].error, ValueError)
    assert [outcomes[i].unwrap() for i in (0, 2, 3)] == [0, 2, 3]


def test_a_task_that_is_lost_for_good_fails_alone(fakes: ModuleType, ray: FakeRay) -> None:
    ray.lost = {2}
    outcomes = {outcome.job: outcome for outcome in RayEngine()(fakes.double, range(4), 2)}
    assert outcomes[1].fault == "its process died (FakeRayError)"
    assert [outcomes[i].unwrap() for i in (0, 2, 3)] == [0, 4, 6]


def test_leaving_early_cancels_what_is_left(fakes: ModuleType, ray: FakeRay) -> None:
    with closing(RayEngine()(fakes.double, range(20), 2)) as outcomes:
        next(outcomes)
    assert len(ray.cancelled) == 3


def test_work_that_workers_cannot_import_is_told(
    fakes: ModuleType, ray: FakeRay, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(FakeRay, "cloudpickle", SimpleNamespace(dumps=lambda value: b"no pickle"))
    with pytest.raises(RunError, match=r"cannot import its work \(.*\); allowed: the same spiraltrunk on every node"):
        list(RayEngine()(fakes.double, range(4), 2))


def test_nothing_reaches_standard_output_and_no_handler_stays(
    fakes: ModuleType, ray: FakeRay, capfd: pytest.CaptureFixture[str]
) -> None:
    before = signal.getsignal(signal.SIGTERM)
    outcomes = RayEngine()(fakes.double, range(2), 1)
    next(outcomes)
    assert signal.getsignal(signal.SIGTERM) is before
    outcomes.close()
    os.write(1, b"the result\n")
    printed = capfd.readouterr()
    assert "what a library prints" in printed.err
    assert printed.out.endswith("the result\n")
    assert "library" not in printed.out


@pytest.mark.parametrize("refusal", [ConnectionError("no head"), RuntimeError("Version mismatch"), ValueError("port")])
def test_a_cluster_that_cannot_be_joined_is_told(fakes: ModuleType, ray: FakeRay, refusal: Exception) -> None:
    ray.refusal = refusal
    with pytest.raises(RunError, match=r"Ray cannot join a cluster at 'auto': .*; allowed: the address of a running"):
        list(RayEngine(address="auto")(fakes.double, range(2), 1))


def test_a_cluster_without_processors_is_told(fakes: ModuleType, ray: FakeRay) -> None:
    ray.cpus = 0
    with pytest.raises(RunError, match="no processors; allowed: nodes with --num-cpus"):
        list(RayEngine(address="auto")(fakes.double, range(2), 1))


def test_a_ray_of_the_caller_stays(fakes: ModuleType, ray: FakeRay) -> None:
    ray.is_up = True
    assert len(list(RayEngine()(fakes.double, range(4), 1))) == 4
    assert ray.is_up
    assert ray.asked == {}
    ray.is_up = False


def test_without_ray_the_package_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "ray", None)
    with pytest.raises(MissingPackage, match=r"pip install 'spiraltrunk\[cluster\]'"):
        ray_engine.load_ray()
