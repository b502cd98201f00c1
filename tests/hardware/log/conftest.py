"""Logs to write and to read."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from spiraltrunk.design import presets
from spiraltrunk.design.toml import format_design
from spiraltrunk.hardware.log import LogMetadata, LogWriter

Write = Callable[..., Path]


@pytest.fixture
def build_metadata() -> Callable[..., LogMetadata]:
    """Builds metadata of a log, with changes by name."""
    design = format_design(presets.PAPER)
    return lambda **changes: LogMetadata(**{"design": design, "bus": "virtual", "is_twin": True, **changes})


@pytest.fixture
def motor_values() -> Callable[[int], dict[str, list[float]]]:
    """Builds the fields of a motors' message that tell its number."""
    names = (
        "feedback_time", "angle", "speed", "torque", "torque_sent", "temperature", "voltage", "pull", "tension",
        "felt", "target",
    )  # fmt: skip
    return lambda k: {name: [k + i / 3 for i in range(3)] for name in names}


@pytest.fixture
def write(tmp_path: Path, build_metadata: Callable[..., LogMetadata], motor_values: Callable[..., object]) -> Write:
    """Writes a log of n messages of the motors, one every 2 ms of its clock, and closes it."""

    def write(n: int = 20, name: str = "a.mcap", **changes: object) -> Path:
        with LogWriter(tmp_path / name, 100.0, build_metadata(**changes)) as log:
            for k in range(n):
                log.write("/motors", 100.0 + 0.002 * k, motor_values(k))
        return tmp_path / name

    return write
