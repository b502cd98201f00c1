"""What the tests of design files share."""

import math
from dataclasses import replace

import pytest

from spiraltrunk.design import ArmDesign, format_design, load_design
from spiraltrunk.design.presets import PAPER
from spiraltrunk.errors import DesignError

FULL = replace(
    PAPER,
    name='every "key" \\ has a value',
    gripper=replace(PAPER.gripper, n_leg=2),
    joint=replace(PAPER.joint, stiffness=tuple(1.0 + 0.1 * i for i in range(PAPER.n_joint))),
    housing=replace(PAPER.housing, mass=1.85, neck_mass=0.06),
    arm=ArmDesign(home=(0.0, -math.pi / 4, math.pi / 2)),
)


@pytest.fixture
def full():
    """A design whose file has every key."""
    return FULL


@pytest.fixture
def edit():
    """The file of the full design with another value for one key, or without it where the value is None."""

    def edit(table, name, value, text=None):
        lines, current = [], ""
        for line in (format_design(FULL) if text is None else text).splitlines():
            current = line.strip("[]") if line.startswith("[") else current
            is_meant = current == table and line.startswith(f"{name} = ")
            lines += [] if is_meant and value is None else [f"{name} = {value}" if is_meant else line]
        return "\n".join(lines)

    return edit


@pytest.fixture
def load_text(tmp_path):
    """Load a text or bytes as a design file."""

    def load_text(text):
        path = tmp_path / "trunk.toml"
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return load_design(path)

    return load_text


@pytest.fixture
def refusal(load_text):
    """The one-line error that says why the text is no design."""

    def refusal(text):
        with pytest.raises(DesignError) as caught:
            load_text(text)
        assert "\n" not in str(caught.value)
        assert "; allowed: " in str(caught.value)
        return caught.value

    return refusal
