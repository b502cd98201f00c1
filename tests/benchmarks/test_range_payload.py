"""Range and payload: halving finds the last that holds, failures count, and an interrupted run keeps its table."""

import importlib.util
import json
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from spiraltrunk.errors import ModelError

_SCRIPT = Path(__file__).parents[2] / "benchmarks" / "range_payload.py"


def _load():
    spec = importlib.util.spec_from_file_location("range_payload", _SCRIPT)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


SCRIPT = _load()


@given(st.lists(st.integers(), min_size=1, max_size=12, unique=True), st.integers(0, 12))
def test_halving_finds_the_last_that_holds(values, count):
    """Against trying one after the other."""
    held = set(values[:count])
    expected = values[min(count, len(values)) - 1] if count else None
    assert SCRIPT.last_held(values, held.__contains__) == expected


def test_the_first_seed_that_does_not_hold_ends_it(monkeypatch, capsys):
    tried = []
    monkeypatch.setattr(SCRIPT, "hold_once", lambda width, mass, seed: tried.append(seed) or seed < 1)
    assert not SCRIPT.every_seed(0.06, 0.25, range(3))
    assert tried == [0, 1]
    assert "60 mm, 0.25 kg: 1 of 3 held, then not" in capsys.readouterr().err


def test_what_cannot_be_simulated_is_not_held(monkeypatch):
    def refuse(*arguments, **options):
        raise ModelError("no")

    monkeypatch.setattr(SCRIPT, "run", refuse)
    assert not SCRIPT.hold_once(0.06, 0.25, 0)


def test_figures_stand_beside_the_papers(monkeypatch, capsys, tmp_path):
    """A trunk that holds 20 to 150 mm, and 60 g for every millimetre."""
    monkeypatch.setattr(SCRIPT, "hold_once", lambda width, mass, seed: 0.02 <= width <= 0.15 and mass <= 60 * width)
    assert SCRIPT.main(["--out", str(tmp_path)]) == 0
    table = json.loads((tmp_path / "range_payload.json").read_text())
    assert (table["width_least_m"], table["width_most_m"]) == (0.022, 0.15)
    assert table["payload_kg"] == {"0.033": 1.5, "0.06": 2.8, "0.09": 4.89, "0.12": 4.89}
    said = capsys.readouterr().out
    assert "widest: 150 mm (paper: 267 mm)" in said
    assert "heaviest at 33 mm: 1.5 kg (paper, at 33 mm: 4.89 kg)" in said


def test_interrupted_it_keeps_what_it_has(monkeypatch, capsys, tmp_path):
    def hold_once(width, mass, seed):
        if width > 0.1:
            raise KeyboardInterrupt
        return True

    monkeypatch.setattr(SCRIPT, "hold_once", hold_once)
    assert SCRIPT.main(["--out", str(tmp_path)]) == 130
    table = json.loads((tmp_path / "range_payload.json").read_text())
    assert table["width_least_m"] == 0.014
    assert "width_most_m" not in table
    assert "thinnest: 14 mm" in capsys.readouterr().out


@pytest.mark.parametrize("count", ["0", "-1", "x", "1001"])
def test_a_number_of_seeds_that_makes_no_sense_is_refused(count, capsys):
    with pytest.raises(SystemExit) as exit_info:
        SCRIPT.main(["--seeds", count])
    assert exit_info.value.code == 2
    assert "allowed: a whole number from 1 to 1000" in capsys.readouterr().err


@pytest.mark.slow
def test_the_default_object_is_held_and_a_ton_is_not():
    assert SCRIPT.hold_once(0.06, 0.25, 0)
    assert not SCRIPT.hold_once(0.06, 4.89, 0)
