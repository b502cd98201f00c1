"""``spiraltrunk survey --engine ray`` on real clusters: nothing that has ended is lost, and nothing stays behind."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest

from spiraltrunk import cli

pytestmark = [
    pytest.mark.slow,
    pytest.mark.timeout(1200),
    pytest.mark.skipif(find_spec("ray") is None, reason="needs Ray: pip install 'spiraltrunk[cluster]'"),
]

FAKES = Path(__file__).parents[1] / "workflows" / "survey" / "fakes"

SURVEY = """
import functools, sys
sys.path.insert(0, sys.argv[1])
import survey_fakes
import spiraltrunk.workflows.survey.run_survey as engine
from spiraltrunk import cli
engine.run_survey = functools.partial(engine.run_survey, work=getattr(survey_fakes, sys.argv[2]))
sys.exit(cli.main(["survey", "--strategies", "wrap-vertical,kick", "--trials", "6", "--json", *sys.argv[3:]]))
"""
"""The verb with other trials."""

HEALTH = {
    "health_check_initial_delay_ms": 1000, "health_check_period_ms": 1000, "health_check_timeout_ms": 2000,
    "health_check_failure_threshold": 3,
}  # fmt: skip
"""A node that is silent for some seconds counts as dead; by Ray's own settings, for half a minute."""

STARTED: list[subprocess.Popen[str]] = []
"""Commands of the present test."""

WALL = ("wall_s", "planning_wall_s", "real_time_factor")


@pytest.fixture(autouse=True, scope="module")
def settings() -> Iterator[None]:
    """Workers with the priority of the test, so that a busy machine does not starve them."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("RAY_worker_niceness", "0")
        patch.setenv("RAY_USAGE_STATS_ENABLED", "0")
        yield


@pytest.fixture(autouse=True)
def no_command_stays() -> Iterator[None]:
    """Of a test that fails half-way."""
    yield
    while STARTED:
        running = STARTED.pop()
        if running.poll() is None:
            running.kill()
        running.communicate()


@pytest.fixture
def temporary() -> Iterator[Path]:
    """A folder for temporary files, whose name is short enough for Ray's sockets."""
    folder = Path(tempfile.mkdtemp(prefix="st", dir="/tmp"))
    yield folder
    shutil.rmtree(folder, ignore_errors=True)


def start(work: str, temporary: Path, *arguments: str, **environment: str) -> subprocess.Popen[str]:
    pipe = subprocess.PIPE
    command = [sys.executable, "-c", SURVEY, str(FAKES), work, *arguments]
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        running = subprocess.Popen(
            command, stdout=pipe, stderr=pipe, text=True, start_new_session=True,
            env=os.environ | {"TMPDIR": str(temporary)} | environment,
        )  # fmt: skip
    finally:
        signal.signal(signal.SIGINT, before)
    STARTED.append(running)
    return running


def wait_for(running: subprocess.Popen[str], count: int) -> None:
    """Return once a number of trials has ended."""
    assert running.stderr is not None
    said = []
    for line in running.stderr:
        said.append(line)
        if line.startswith(f"spiraltrunk: {count}/12"):
            return
    raise AssertionError(f"the survey ended before: {''.join(said)}")


def finish(running: subprocess.Popen[str]) -> dict[str, Any]:
    """The printed result of a survey."""
    printed, said = running.communicate(timeout=900)
    assert running.returncode == 0, said
    return json.loads(printed)


def find_processes(folder: Path) -> list[str]:
    """Commands of the living processes that use a folder."""
    found = []
    for path in Path("/proc").glob("[0-9]*/cmdline"):
        try:
            command = path.read_bytes().replace(b"\0", b" ").decode(errors="replace")
        except OSError:
            continue
        if f"{folder}/" in command:
            found.append(command)
    return found


def is_left(folder: Path, patience: float = 60.0) -> bool:
    """Whether processes that use the folder stay."""
    end = time.monotonic() + patience
    while find_processes(folder) and time.monotonic() < end:
        time.sleep(0.2)
    return bool(find_processes(folder))


def read_rows(folder: Path) -> list[dict[str, Any]]:
    rows = json.loads((folder / "survey.json").read_text())["rows"]
    return [{key: value for key, value in row.items() if key not in WALL} for row in rows]


@pytest.fixture(scope="module")
def local(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The same survey by the pool of this machine."""
    folder = tmp_path_factory.mktemp("local")
    finish(start("work", folder, "--workers", "1", "--out", str(folder / "out")))
    return folder / "out"


def check_same(out: Path, local: Path) -> None:
    assert (out / "table.md").read_bytes() == (local / "table.md").read_bytes()
    assert read_rows(out) == read_rows(local)


def test_a_node_that_is_killed_costs_no_trial(local: Path, temporary: Path, tmp_path: Path) -> None:
    """Two nodes, each a raylet with its own heart-beat; one is killed while it works."""
    from ray.cluster_utils import Cluster

    cluster = Cluster(
        initialize_head=True, head_node_args={"num_cpus": 1, "include_dashboard": False, "_system_config": HEALTH}
    )
    try:
        second = cluster.add_node(num_cpus=1)
        running = start(
            "work_slowly", temporary, "--engine", "ray", "--address", cluster.address, "--out", str(tmp_path / "out")
        )
        wait_for(running, 3)
        cluster.remove_node(second, allow_graceful=False)
        assert finish(running)["complete"]
    finally:
        cluster.shutdown()
    check_same(tmp_path / "out", local)


def test_a_worker_that_is_killed_costs_no_trial(local: Path, temporary: Path, tmp_path: Path) -> None:
    running = start(
        "die_once", temporary, "--engine", "ray", "--workers", "2", "--out", str(tmp_path / "out"),
        SURVEY_FAKES_DEAD=str(tmp_path / "dead"),
    )  # fmt: skip
    assert finish(running)["complete"]
    assert (tmp_path / "dead").exists()
    check_same(tmp_path / "out", local)
    assert not is_left(temporary)
    assert list(temporary.iterdir()) == []


def test_a_driver_that_is_killed_loses_no_trial_that_has_ended(local: Path, temporary: Path, tmp_path: Path) -> None:
    arguments = ("--engine", "ray", "--workers", "2", "--out", str(tmp_path / "out"))
    running = start("work_slowly", temporary, *arguments)
    wait_for(running, 3)
    running.kill()
    running.communicate(timeout=60)
    assert len((tmp_path / "out" / "trials.jsonl").read_text().splitlines()) >= 3
    assert not is_left(temporary), "Ray lives on"
    again = start("work", temporary, "--workers", "1", "--out", str(tmp_path / "out"))
    assert finish(again)["complete"]
    check_same(tmp_path / "out", local)


def test_ctrl_c_stops_ray_and_leaves_nothing(temporary: Path, tmp_path: Path) -> None:
    running = start("hang_after_third", temporary, "--engine", "ray", "--workers", "2", "--out", str(tmp_path / "out"))
    wait_for(running, 3)
    os.killpg(running.pid, signal.SIGINT)
    printed, said = running.communicate(timeout=300)
    assert (running.returncode, printed) == (130, ""), said
    assert said.splitlines()[-2:] == [
        f"spiraltrunk: {len(read_rows(tmp_path / 'out'))} of 12 trials are in {tmp_path / 'out'}; "
        "the same command goes on with the rest",
        "spiraltrunk: interrupted",
    ]
    assert not is_left(temporary)
    assert list(temporary.iterdir()) == []


def test_an_address_without_a_cluster_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["survey", "--trials", "1", "--engine", "ray", "--address", "auto"]) == 1
    printed = capsys.readouterr()
    assert "Ray cannot join a cluster at 'auto'" in printed.err
    assert printed.out == ""
