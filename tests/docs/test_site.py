"""The site's own extensions: the command line from its parser, docstrings as plain text, equations, links."""

from __future__ import annotations

import importlib.util
import re
from pathlib import Path
from types import ModuleType

import pytest

from spiraltrunk.cli.entry import _build_parser

ROOT = Path(__file__).parents[2]
EXTENSIONS = ROOT / "docs" / "_ext"


def load(name: str) -> ModuleType:
    pytest.importorskip("sphinx")
    spec = importlib.util.spec_from_file_location(name, EXTENSIONS / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_reference_has_every_verb_and_option() -> None:
    reference = load("cli_reference")
    text = reference.format_reference(_build_parser())
    verbs = reference.find_verbs(_build_parser())
    assert {"design", "shape", "grasp", "survey", "validate", "calibrate", "export", "bench", "drive"} <= verbs.keys()
    assert all(f".. _cli-{name}:" in text for name in verbs)
    inner = {
        f"{name} {action}": found
        for name, (verb, _) in verbs.items()
        for action, found in reference.find_verbs(verb).items()
    }
    assert "drive jog" in inner
    for name, (verb, told) in {**verbs, **inner}.items():
        assert f".. program:: spiraltrunk {name}\n" in text
        assert told
        for action in verb._actions:
            assert all(
                f".. option:: {option}" in text
                for option in action.option_strings
                if option != "-h" and option != "--help"
            )


def test_markup_in_docstrings_stands_for_itself() -> None:
    lines = ["Energy sum |q|^2 * K_ and ``a | b`` and `Shape`.", "", "    literal::", "", "        |x| * y"]
    load("plain_docstrings").escape(lines)
    assert lines[0] == r"Energy sum \|q\|^2 \* K\_ and ``a | b`` and `Shape`."
    assert lines[4] == "        |x| * y"


def test_every_equation_of_the_pages_can_be_drawn() -> None:
    draw = load("mathtext_svg").draw
    pages = "\n".join(path.read_text() for path in (ROOT / "docs").rglob("*.md") if "examples" not in path.parts)
    text = re.sub(r"```.*?```|`[^`]*`", "", pages, flags=re.S)
    block = re.findall(r"\$\$(.+?)\$\$", text, flags=re.S)
    inline = re.findall(r"\$([^$]+)\$", re.sub(r"\$\$.+?\$\$", "", text, flags=re.S))
    assert len(block) > 5
    assert len(inline) > 20
    for tex in (*block, *inline):
        assert draw(re.sub(r"\s+", " ", tex).strip()).startswith("<svg")


def test_a_broken_link_is_found(tmp_path: Path) -> None:
    find_broken = load("check_links").find_broken
    (tmp_path / "index.html").write_text('<a href="a.html#here">x</a><img src="no.png"><a href="https://a.b/c">y</a>')
    (tmp_path / "a.html").write_text('<p id="here"><a href="#gone">z</a>')
    assert find_broken(tmp_path) == ["a.html: #gone", "index.html: no.png"]


def test_pages_at_the_root_keep_their_links_within_the_site() -> None:
    pages = load("root_pages").PAGES
    for page, name in pages.items():
        assert (ROOT / name).is_file()
        assert (ROOT / "docs" / f"{page}.md").is_file()
