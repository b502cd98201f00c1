"""Errors say one line, and SAFETY.md names what opens a port."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

import spiraltrunk
from spiraltrunk import errors

ROOT = Path(__file__).parents[1]
PLAIN = [
    kind
    for kind in vars(errors).values()
    if isinstance(kind, type) and issubclass(kind, errors.SpiralTrunkError) and "__init__" not in vars(kind)
]
NETWORK = {"socket", "natnet", "can", "serial", "http", "urllib", "requests", "viser", "asyncio", "socketserver"}


@pytest.mark.parametrize("kind", PLAIN)
def test_message_is_one_line(kind: type[errors.SpiralTrunkError]) -> None:
    assert str(kind("given:\n  [[1 2]\n   [3 4]]")) == "given: [[1 2] [3 4]]"


def test_message_of_each_error_with_parts_is_one_line() -> None:
    assert "\n" not in str(errors.DesignError("m", got="a\nb", allowed="one\nline", file="x\ny"))
    assert "\n" not in str(errors.TakeError("what\never", file="x\ny", line=1, column=2))
    assert "\n" not in str(errors.UnknownName("strategy", "a\nb", ["c\nd"]))


def test_safety_names_every_module_that_opens_a_port() -> None:
    found = set()
    for path in Path(spiraltrunk.__file__).parent.rglob("*.py"):
        text = path.read_text()
        if not any(name in text for name in NETWORK):
            continue  # Reading it as text takes a tenth of the time.
        for node in ast.walk(ast.parse(text)):
            names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            if isinstance(node, ast.ImportFrom) and (node.module != "viser" or "ViserServer" in ast.unparse(node)):
                names += [node.module or ""]  # Of viser, its server alone opens a port.
            names = [name for name in names if name != "urllib.parse"]  # It reads addresses, and opens none.
            if {name.partition(".")[0] for name in names} & NETWORK:
                found.add(path.relative_to(Path(spiraltrunk.__file__).parents[1]).with_suffix("").as_posix())
    assert found
    said = (ROOT / "SAFETY.md").read_text()
    assert [module for module in sorted(found) if module.replace("/", ".") not in said] == []
