"""The benchmark of the choice: objects are drawn once for all, rates are counted by class, interrupted runs go on."""

import importlib.util
import json
from pathlib import Path

import pytest

from spiraltrunk.sim.objects.catalogue import parse_object

PATH = Path(__file__).parents[2] / "benchmarks" / "auto_choice.py"


@pytest.fixture
def choice():
    spec = importlib.util.spec_from_file_location("auto_choice", PATH)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def _row(index, lifted, wrong, kind="tall"):
    outcomes = {
        key: None if success is None else {"success": success, "reason": "-", "tries": ["pinch"], "strategy": "pinch"}
        for key, success in (("auto", lifted), ("forced", wrong))
    }
    return {"index": index, "object": f"thing-{index}", "class": kind, "feasible": {}, **outcomes}


def test_objects_are_drawn_once_for_all(choice):
    texts = [choice.draw_object(index) for index in range(12)]
    assert texts == [choice.draw_object(index) for index in range(12)]
    assert {"pose=lying" in text for text in texts} == {True, False}
    assert {choice.classify(parse_object(text)) for text in texts} <= {"tall", "compact", "flat"}


def test_both_ways_of_being_wrong_are_counted(choice):
    rows = [_row(0, True, False), _row(1, False, None, "flat"), _row(2, None, True), _row(3, True, False)]
    summary = choice.summarize(rows, 4)
    assert summary["rates"]["auto"]["all"]["successes"] == 2
    assert summary["rates"]["auto"]["flat"]["rate"] == 0.0
    assert summary["rates"]["forced"]["all"]["rate"] == pytest.approx(1 / 3)
    assert (summary["feasible"], summary["is_complete"], summary["holds"]) == (3, True, False)
    assert choice.summarize([_row(0, True, False)], 1)["holds"]


def test_the_same_command_goes_on(choice, monkeypatch, tmp_path):
    ran = []

    def run_index(index, *, share):
        ran.append(index)
        if index == 2 and len(ran) == 3:
            raise KeyboardInterrupt
        return _row(index, True, False)

    monkeypatch.setattr(choice, "run_index", run_index)
    argv = ["--objects", "4", "--workers", "1", "--out", str(tmp_path)]
    assert choice.main(argv) == 130
    assert choice.main(argv) == 0
    assert ran == [0, 1, 2, 2, 3]
    assert json.loads((tmp_path / "auto_choice.json").read_text())["objects"] == 4
