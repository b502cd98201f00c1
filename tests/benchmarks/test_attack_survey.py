"""The script that spoils a survey's folder runs, and a resumption that is wrong is noticed."""

from __future__ import annotations

import importlib.util
import json
import subprocess
import sys
from pathlib import Path

import pytest

SCRIPT = Path(__file__).parents[2] / "benchmarks" / "attack_survey.py"


@pytest.fixture(scope="module")
def attack():
    spec = importlib.util.spec_from_file_location("attack_survey", SCRIPT)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.slow
@pytest.mark.parametrize("count", [20, 2000])
def test_spoiled_surveys_go_on_or_are_refused(count: int) -> None:
    """A process of its own, as the tries use the alarm."""
    command = [sys.executable, str(SCRIPT), "--count", str(count), "--seed", "2"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert found["tries"] == sum(found["outcomes"].values()) == count
    assert found["faults"] == 0
    assert found["outcomes"]["refused"] > count // 3
    assert found["outcomes"]["went on"] >= 1


def test_every_field_is_spoiled(attack) -> None:
    document = {"a": {"b": [{"c": 1}]}, "d": None}
    assert list(attack._paths(document)) == [("a",), ("a", "b"), ("a", "b", 0), ("d",)]
    assert attack.spoil(document, ("a", "b"), attack.MISSING) == '{"a": {}, "d": null}'
    assert attack.spoil(document, ("a", "b", 0), 5) == '{"a": {"b": [5]}, "d": null}'


@pytest.mark.parametrize(
    ("outcome", "fault"),
    [((2, "", "spiraltrunk: error: a"), None), ((2, "", ""), "0 errors"), ((1, "", ""), "exit 1"),
     (("Traceback", "", ""), "Traceback"), ((2, "", "spiraltrunk: error: a\nb"), "line on standard error"),
     ((0, "{}", ""), "ended, but")],
)  # fmt: skip
def test_what_must_not_be_is_noticed(attack, tmp_path, outcome, fault) -> None:
    found = list(attack.find_faults(tmp_path, {}, outcome))
    assert (fault in found[0]) if fault else not found


def test_a_change_of_a_refused_folder_is_noticed(attack, tmp_path) -> None:
    (tmp_path / "a").write_text("one")
    before = attack.look(tmp_path)
    (tmp_path / "a").write_text("two")
    refused = (2, "", "spiraltrunk: error: no survey")
    assert list(attack.find_faults(tmp_path, before, refused)) == ["refused, but changed ['a']"]
