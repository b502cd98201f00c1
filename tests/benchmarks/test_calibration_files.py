"""The script that counts coverage through files lists the subsets and counts rightly."""

import importlib.util
import json
from pathlib import Path

import pytest

PATH = Path(__file__).parents[2] / "benchmarks" / "calibration_files.py"


@pytest.fixture(scope="module")
def files():
    spec = importlib.util.spec_from_file_location(PATH.stem, PATH)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_subsets_are_all_and_those_of_few_are_among_them(files):
    every, few = files.list_subsets("subsets"), files.list_subsets("few")
    assert len(every) == len(set(every)) == 63
    assert len(few) == len(set(few)) == 15
    assert set(few) <= set(every)
    assert files.RUNS in few
    assert files.DOCS in few


@pytest.mark.parametrize(("true", "away"), [(0.2, 0.0), (0.23, 0.5), (0.19, 1.0), (0.32, 2.0)])
def test_the_truth_is_inside_its_interval_up_to_one(files, true, away):
    interval = {"value": 0.2, "low_95": 0.19, "high_95": 0.26}
    assert files.compute_away(interval, true) == pytest.approx(away)


def test_the_table_counts_fits_inside_and_a_cut_off_line_is_left_out(files, tmp_path):
    def row(runs, away):
        names = dict.fromkeys(files.CABLES, away)
        return {
            "seed": 1, "runs": runs, "held_out_m": {"bend-dorsal": 1e-3 * away}, "value": {"friction": 0.2},
            "away": names, "is_told": dict.fromkeys(names, True),
        }  # fmt: skip

    path = tmp_path / "rows.jsonl"
    rows = [row(list(files.RUNS), 0.5), row(["bend-dorsal"], 2.0)]
    path.write_text("".join(json.dumps(one) + "\n" for one in rows) + '{"seed": 2, ')
    assert files.load_rows(path) == rows
    bending, both, every = files.format_table(rows).splitlines()[2:]
    assert bending.startswith("| bending | 1 | 2.00 | 2.00 | 0 | 0 of 1 | 0.200 to 0.200 | 0 of 5 |")
    assert both.startswith("| bending and twist | 1 | 0.50 ")
    assert every.startswith("| all first takes | 1 | 0.50 | 0.50 | 1 | 1 of 1 ")
