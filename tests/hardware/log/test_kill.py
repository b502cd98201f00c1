"""A process that is killed leaves a log that opens; `benchmarks/kill_log.py` in short."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path

import pytest

SCRIPT = Path(__file__).parents[3] / "benchmarks" / "kill_log.py"


@pytest.mark.parametrize("count", [2, pytest.param(5, marks=pytest.mark.slow)])
def test_logs_of_killed_processes_open_and_begin_as_reported(count: int) -> None:
    spec = importlib.util.spec_from_file_location("kill_log", SCRIPT)
    assert spec is not None
    assert spec.loader is not None
    script = sys.modules["kill_log"] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(script)
    kills = script.kill_often(count, seed=1, longest=0.6)
    print(script.format_table(kills))
    assert [kill.error for kill in kills] == [None] * count
    assert all(kill.reported for kill in kills)
