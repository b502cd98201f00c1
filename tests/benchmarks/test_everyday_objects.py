"""The benchmark of everyday things: what is drawn, what counts, and that it goes on where it ended."""

import importlib.util
import json
import sys
from pathlib import Path

import pytest

SCRIPT = Path(__file__).parents[2] / "benchmarks" / "everyday_objects.py"
SPEC = importlib.util.spec_from_file_location("everyday_objects", SCRIPT)
everyday = importlib.util.module_from_spec(SPEC)
sys.modules[SPEC.name] = everyday  # Dataclasses look their module up.
SPEC.loader.exec_module(everyday)


@pytest.fixture
def run(monkeypatch, tmp_path):
    """Runs the script with outcomes in place of trials; gives the exit code and the seeds that were tried."""

    def run(outcomes, *arguments):
        tried = []

        def run_seed(name, seed, design):
            tried.append(seed)
            if isinstance(outcomes[seed], BaseException):
                raise outcomes[seed]
            entries = dict.fromkeys(("success", "held", "upright"), outcomes[seed] == "held")
            return {"part": name, "seed": seed, "refused": outcomes[seed] == "refused", **entries}

        monkeypatch.setattr(everyday, "run_seed", run_seed)
        out = ("--out", str(tmp_path / "rows.jsonl"), "--first-seed", "1", "--trials", str(len(outcomes)))
        return everyday.main(["--part", "upright", *out, *arguments]), tried

    return run


@pytest.mark.parametrize("seed", range(1000, 1030))
def test_what_stands_is_of_its_class(seed):
    _, shape = everyday.draw_upright(seed)
    assert 0.08 <= shape.size[0] <= 0.24
    assert min(shape.size[1:]) <= 0.0805
    assert shape.mass <= 0.4


def test_a_refusal_is_no_trial_and_a_rate_below_its_bar_fails(run, capsys):
    assert run({1: "held", 2: "refused", 3: "held"})[0] == 0
    assert "upright, held: 2 of 2" in capsys.readouterr().out
    assert run({1: "held", 2: "refused", 3: "held", 4: "dropped"}) == (1, [4])
    assert "upright, held: 2 of 3 (21 to 94 % at 95 %); asked for: 90 %\n" in capsys.readouterr().out


def test_it_goes_on_where_it_was_interrupted_and_not_with_rows_of_other_code(run, monkeypatch, tmp_path):
    assert run({1: "held", 2: KeyboardInterrupt(), 3: "held"}) == (130, [1, 2])
    rows = tmp_path / "rows.jsonl"
    rows.write_text(rows.read_text() + '{"part": "upri')
    assert run({1: "held", 2: "held", 3: "held"}) == (0, [2, 3])
    assert [json.loads(line)["seed"] for line in rows.read_text().splitlines()] == [1, 2, 3]
    monkeypatch.setattr(everyday, "compute_source", lambda: "other code")
    assert run({1: "held", 2: "held", 3: "held"}) == (0, [1, 2, 3])
