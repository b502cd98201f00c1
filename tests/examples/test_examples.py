"""Every example runs and holds what it asserts."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

FOLDER = Path(__file__).parents[2] / "examples"
EXAMPLES = sorted(path.name for path in FOLDER.glob("[0-9]*.py"))
LONG = {"10_own_strategy.py", "20_own_stl.py", "31_calibrate.py", "40_make_parts.py", "50_environment.py"}
"""Examples of which other tests run every part."""


def test_there_are_examples():
    assert EXAMPLES


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=pytest.mark.slow) if name in LONG else name for name in EXAMPLES]
)
def test_an_example_runs(name, tmp_path):
    environment = os.environ | {"OPENBLAS_NUM_THREADS": "1"}
    done = subprocess.run(
        [sys.executable, str(FOLDER / name)], cwd=tmp_path, env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert "assert" in (FOLDER / name).read_text()
