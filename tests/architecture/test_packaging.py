"""What pyproject.toml asks for is what constraints.txt pins."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name
from packaging.version import Version

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
REQUIREMENTS = [
    Requirement(line)
    for extra in (PROJECT["dependencies"], *(PROJECT["optional-dependencies"][name] for name in ("dev", "peers")))
    for line in extra
]


def load_pins() -> dict[str, str]:
    lines = (ROOT / "constraints.txt").read_text().splitlines()
    pairs = [line.split("==") for line in lines if line and not line.startswith("#")]
    return {canonicalize_name(name): version for name, version in pairs}


@pytest.mark.parametrize("requirement", REQUIREMENTS, ids=lambda requirement: requirement.name)
def test_requirement_is_pinned_within_its_range(requirement: Requirement) -> None:
    assert requirement.specifier.contains(load_pins()[canonicalize_name(requirement.name)])


def test_pins_are_plain_versions() -> None:
    pins = load_pins()
    assert len(pins) > len(REQUIREMENTS)
    for version in pins.values():
        assert str(Version(version)) == version


def test_a_version_is_cited_when_it_is_released() -> None:
    """Until then neither the citation nor the changelog claims one."""
    released = re.findall(r"^## \[(\d\S*)\] - \d{4}-\d\d-\d\d$", (ROOT / "CHANGELOG.md").read_text(), flags=re.M)
    citation = (ROOT / "CITATION.cff").read_text()
    cited = re.findall(r"^version: (\S+)$", citation, flags=re.M)
    assert cited == released[:1]
    assert ("date-released" in citation) == bool(released)
