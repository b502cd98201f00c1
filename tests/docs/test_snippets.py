"""What the pages of the site show in code works: every block is run, parsed or checked by its kind.

A line `% slow` before a block leaves it to the slow tests, `% no-run` to the compiler alone.
"""

from __future__ import annotations

import contextlib
import io
import json
import re
import shlex
import tomllib
from dataclasses import dataclass
from pathlib import Path

import pytest

from spiraltrunk import cli
from spiraltrunk.cli.entry import _build_parser

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
PAGES = sorted(path for path in DOCS.rglob("*.md") if "examples" not in path.parts)
KINDS = {"python", "bash", "text", "toml", "json"}
READERS = {"toml": tomllib.loads, "json": json.loads}
CHEAP = re.compile(r"spiraltrunk (design|shape (?!.*(statics|--plot))|validate --plan|--version)")
"""Commands that are run: those that take less than a second."""


@dataclass(frozen=True, kw_only=True)
class Block:
    """A block of code with what stands before it."""

    mark: str
    kind: str
    text: str


def read_blocks(text: str) -> list[Block]:
    found = re.findall(r"^(?:% ([\w-]+)\n)?```(\S*)\n(.*?)^```$", text, flags=re.M | re.S)
    return [Block(mark=mark, kind=kind, text=code) for mark, kind, code in found]


def is_directive(block: Block) -> bool:
    return block.kind.startswith("{")


BLOCKS = {str(path.relative_to(DOCS)): read_blocks(path.read_text()) for path in PAGES}
PYTHON = {page: [b for b in blocks if b.kind == "python"] for page, blocks in BLOCKS.items()}
RUN = [page for page, blocks in PYTHON.items() if any(not b.mark for b in blocks)]
SLOW = [page for page, blocks in PYTHON.items() if any(b.mark == "slow" for b in blocks)]


def split_commands(text: str) -> list[str]:
    lines = text.replace("\\\n", " ").splitlines()
    return [line.partition(" #")[0].strip() for line in lines if line.strip() and not line.startswith("#")]


COMMANDS = sorted(
    {line for blocks in BLOCKS.values() for b in blocks if b.kind == "bash" for line in split_commands(b.text)}
)


def test_no_block_is_of_a_kind_that_nothing_checks() -> None:
    assert len(RUN) > 5
    assert len(COMMANDS) > 20
    for page, blocks in BLOCKS.items():
        kinds = {block.kind for block in blocks if not is_directive(block)}
        assert kinds <= KINDS, page
        assert {block.mark for block in blocks} <= {"", "slow", "no-run"}, page


def run_page(page: str, *, with_slow: bool) -> tuple[list[str], list[str]]:
    """Lines that the blocks of a page print, and those that their comments say."""
    space: dict[str, object] = {"__name__": "page"}
    printed, said = io.StringIO(), []
    for block in PYTHON[page]:
        code = compile(block.text, page, "exec", dont_inherit=True)
        if block.mark == "no-run" or (block.mark == "slow" and not with_slow):
            continue
        with contextlib.redirect_stdout(printed):
            exec(code, space)
        said += re.findall(r"^ *print\(.*\)  # (.*)$", block.text, flags=re.M)
    return printed.getvalue().splitlines(), said


@pytest.mark.parametrize("page", RUN)
def test_python_runs_and_prints_what_its_comments_say(
    page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    printed, said = run_page(page, with_slow=False)
    assert printed == said


@pytest.mark.slow
@pytest.mark.parametrize("page", SLOW)
def test_slow_python_runs_too(page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    printed, said = run_page(page, with_slow=True)
    assert printed == said


@pytest.mark.parametrize("command", COMMANDS)
def test_a_command_exists(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    words = shlex.split(command)
    if words[0] == "spiraltrunk":
        _parse(words[1:])
    elif words[0] == "make":
        assert re.search(rf"^{words[-1]}:", (ROOT / "Makefile").read_text(), flags=re.M)
    elif words[:2] == ["pip", "install"]:
        extras = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["optional-dependencies"]
        assert set(re.findall(r"\w+", words[2].partition("[")[2])) <= extras.keys()
    else:
        assert words[0] == "python"
        assert words[1] == "-m" or (ROOT / words[1]).is_file()


def _parse(words: list[str]) -> None:
    """Through the parser alone; options that end the program are done then."""
    try:
        _build_parser().parse_args(words)
    except SystemExit as stop:
        code = stop.code
    else:
        code = 0
    assert not code


def _find_cheap() -> list[tuple[str, str]]:
    found = []
    for blocks in BLOCKS.values():
        for block, after in zip(blocks, [*blocks[1:], None], strict=False):
            commands = split_commands(block.text) if block.kind == "bash" else []
            shown = after.text if after is not None and after.kind == "text" and "$ " not in after.text else ""
            for command in commands:
                is_last = command == commands[-1]
                if CHEAP.match(command) and "calibrated" not in command:
                    found.append((command, shown if is_last else ""))
    return found


@pytest.mark.parametrize(("command", "shown"), _find_cheap())
def test_a_cheap_command_prints_what_the_page_shows(
    command: str, shown: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert cli.main(shlex.split(command)[1:]) == 0
    if shown:
        assert capsys.readouterr().out.strip() == shown.strip()


def test_refusals_are_told_as_the_pages_show_them(capsys: pytest.CaptureFixture[str]) -> None:
    text = "\n".join(b.text for blocks in BLOCKS.values() for b in blocks if b.kind == "text")
    refused = re.findall(r"^\$ spiraltrunk (.*)\n(spiraltrunk: error: .*)$", text, flags=re.M)
    assert refused
    for words, said in refused:
        assert cli.main(shlex.split(words)) == 2
        assert capsys.readouterr().err.strip() == said


@pytest.mark.parametrize("page", [page for page, blocks in BLOCKS.items() if any(b.kind in READERS for b in blocks)])
def test_toml_and_json_can_be_read(page: str) -> None:
    for block in BLOCKS[page]:
        if block.kind in READERS:
            assert READERS[block.kind](block.text), block.text
