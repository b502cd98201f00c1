"""The script that measures the twin's speed."""

from __future__ import annotations

import importlib.util
from pathlib import Path

FILE = Path(__file__).parents[3] / "benchmarks" / "hardware_twin_speed.py"


def test_the_script_measures_what_it_says() -> None:
    """Three motors answer at 500 Hz; how fast that goes is no test's business."""
    spec = importlib.util.spec_from_file_location("hardware_twin_speed", FILE)
    assert spec is not None
    assert spec.loader is not None
    script = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(script)
    figures = script.run(0.5)
    assert figures["frames"] == 3 * 250
    assert figures["factor"] > 0.0
    assert figures["bar"] == 15.0
