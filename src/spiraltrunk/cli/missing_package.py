"""How to install a package that is not there."""

from __future__ import annotations

import re
from importlib.metadata import PackageNotFoundError, requires

_DISTRIBUTIONS = {"PIL": "pillow"}
"""Packages whose distribution has another name."""

_REQUIREMENT = re.compile(r"([\w.-]+)(\[[^]]*\])?\s*([^;\s]*)\s*(?:;.*extra\s*==\s*[\"']([\w-]+)[\"'])?")
"""Name, extras, versions and own extra of a line of ``Requires-Dist``."""


def describe_missing(module: str) -> str:
    """One line on a module that cannot be imported: its package and the command that installs it."""
    package = module.partition(".")[0]
    wanted = _normalise(_DISTRIBUTIONS.get(package, package))
    found = {extra: versions for name, versions, extra in _read_requirements() if name == wanted}
    if not found:
        command = "pip install --force-reinstall spiraltrunk"
    elif "" in found:
        command = f"pip install '{wanted}{found['']}'"
    else:
        extra = min(found, key=lambda name: name in ("dev", "docs"))
        command = f"pip install 'spiraltrunk[{extra}]'"
    return f"the package {package!r} is not installed: {command}"


def _read_requirements() -> list[tuple[str, str, str]]:
    """Name, versions and extra, or an empty text, of each requirement of this package."""
    try:
        lines = requires("spiraltrunk") or []
    except PackageNotFoundError:  # Run from its source.
        return []
    found = [match for line in lines if (match := _REQUIREMENT.match(line))]
    return [(_normalise(match[1]), match[3], match[4] or "") for match in found]


def _normalise(name: str) -> str:
    return re.sub(r"[-_.]+", "-", name).lower()
