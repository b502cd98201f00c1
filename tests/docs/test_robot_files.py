"""Robot files that the pages show are robot files, and fit the preset `paper`."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from spiraltrunk.design.presets import PAPER
from spiraltrunk.hardware.setup.robot_file import EXAMPLE, TABLES, parse_robot_file
from spiraltrunk.hardware.setup.robot_limits import build_winders

DOCS = Path(__file__).parents[2] / "docs"
PAGE = (DOCS / "tutorials" / "hardware.md").read_text()
FILES = re.findall(r"^```toml\n(schema = .*?)^```$", PAGE, flags=re.M | re.S)


def test_there_is_one_for_each_family() -> None:
    assert [re.findall(r'family = "(\w+)"', text) for text in FILES] == [["gm6020"], ["sts"]]


@pytest.mark.parametrize("text", FILES)
def test_it_can_be_read_and_fits(text: str) -> None:
    file = parse_robot_file(text.encode(), source="page")
    winders = build_winders(PAPER, file)
    assert all(winder.limits.tension_ceiling == file.cables.tension_max for winder in winders)


def test_the_reference_has_every_key_and_the_example() -> None:
    reference = (DOCS / "reference" / "robot_file.md").read_text()
    assert f"```toml\n{EXAMPLE}```" in reference
    for table, keys in TABLES.items():
        for key in keys:
            shown = f"`{table}.{key.name}`".replace("`.", "`")
            assert shown in reference or f"`{table}.*_us`" in reference
