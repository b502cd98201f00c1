"""What README.md shows in code works: every block of code is run or checked by its kind."""

from __future__ import annotations

import contextlib
import io
import re
import shutil
import subprocess
from pathlib import Path

import pytest

from spiraltrunk import cli

ROOT = Path(__file__).parents[1]
TEXT = (ROOT / "README.md").read_text()
BLOCKS = re.findall(r"^```(\w*)\n(.*?)^```$", TEXT, flags=re.M | re.S)
PYTHON = [code for language, code in BLOCKS if language == "python"]
SHELL = [line for language, code in BLOCKS if language == "bash" for line in code.splitlines()]
COMMANDS = sorted(set(re.findall(r"`spiraltrunk (\w+)", TEXT)))


def test_no_block_is_of_a_kind_that_nothing_checks() -> None:
    assert PYTHON
    assert SHELL
    assert {language for language, _ in BLOCKS} <= {"python", "bash", ""}
    assert TEXT.count("```") == 2 * len(BLOCKS)


@pytest.mark.parametrize("code", PYTHON)
def test_python_runs_and_prints_what_its_comments_say(code: str) -> None:
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        exec(compile(code, "README.md", "exec"), {})
    assert printed.getvalue().splitlines() == re.findall(r"^print\(.*\)  # (.*)$", code, flags=re.M)


@pytest.mark.skipif(shutil.which("make") is None, reason="no make here")
@pytest.mark.parametrize("line", SHELL)
def test_make_knows_its_targets(line: str) -> None:
    command = line.partition("#")[0].split()
    assert command[0] == "make"
    subprocess.run([*command, "--dry-run"], cwd=ROOT, check=True, capture_output=True)


def test_the_folders_of_the_flow_exist() -> None:
    flow = next(code for language, code in BLOCKS if not language)
    folders = re.findall(r"\w+", flow.splitlines()[0])
    assert len(folders) == 5
    assert all((ROOT / "src" / "spiraltrunk" / folder).is_dir() for folder in folders)


@pytest.mark.parametrize("verb", COMMANDS)
def test_the_commands_exist(verb: str) -> None:
    assert cli.main([verb, "--help"]) == 0
