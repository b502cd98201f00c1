"""The tour's table of what does the same without the page: its commands, options and Python names exist."""

import importlib
import re
from pathlib import Path

import pytest

from spiraltrunk.cli import main

PAGE = Path(__file__).parents[2] / "docs" / "tutorials" / "studio.md"


def read_rows():
    section = PAGE.read_text().partition("## The same without the page")[2].partition("\n## ")[0]
    rows = [[cell.strip() for cell in line.split("|")[1:-1]] for line in section.splitlines() if line.startswith("|")]
    return rows[2:]


def read_codes(cell):
    return re.findall(r"`([^`]+)`", cell)


def test_each_tab_is_there_and_each_row_has_an_equivalent():
    rows = read_rows()
    assert {row[0] for row in rows} == {"Design", "Shape", "Grasp", "Measure", "Robot"}
    assert all(read_codes(row[3]) for row in rows)


@pytest.mark.parametrize("name", sorted({name for row in read_rows() for name in read_codes(row[3])}))
def test_python_names_exist(name):
    module, _, attribute = f"spiraltrunk.{name}".rpartition(".")
    assert hasattr(importlib.import_module(module), attribute)


@pytest.mark.parametrize("command", sorted({code for row in read_rows() for code in read_codes(row[2])}))
def test_commands_and_their_options_exist(command, capsys):
    program, verb, *rest = command.split()
    assert program == "spiraltrunk"
    words = rest[:1] if verb == "drive" else []
    assert main([verb, *words, "--help"]) == 0
    told = capsys.readouterr().out
    for option in (one for one in rest if one.startswith("--")):
        assert re.search(rf"{option}\b", told)
