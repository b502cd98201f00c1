"""`help` of a class that users make or read shows each field's meaning and unit."""

from __future__ import annotations

import ast
import dataclasses
import importlib
import inspect
import itertools
import pydoc
import sys
from pathlib import Path

import pytest

import spiraltrunk
from spiraltrunk.field_docs import explain_fields, read_field_docs
from spiraltrunk.model.statics import StaticsOptions

PACKAGE = Path(spiraltrunk.__file__).parent
CLASSES = {
    (path.relative_to(PACKAGE.parent).with_suffix("").as_posix().replace("/", "."), node.name): node
    for path in PACKAGE.rglob("*.py")
    for node in ast.parse(path.read_text()).body
    if isinstance(node, ast.ClassDef) and any("explain_fields" in ast.unparse(each) for each in node.decorator_list)
}
OPTIONS = {
    (path.relative_to(PACKAGE.parent).with_suffix("").as_posix().replace("/", "."), node.name)
    for path in PACKAGE.rglob("*.py")
    for node in ast.parse(path.read_text()).body
    if isinstance(node, ast.ClassDef) and node.name.endswith("Options")
}


@pytest.mark.parametrize(("module", "name"), CLASSES)
def test_help_shows_every_field(module: str, name: str) -> None:
    shown = pydoc.render_doc(getattr(importlib.import_module(module), name), renderer=pydoc.plaintext)
    head = shown.partition("Methods defined here")[0]
    cls = getattr(sys.modules[module], name)
    written = {
        field.target.id: inspect.cleandoc(text.value.value).splitlines()
        for base in cls.__mro__
        for node in [CLASSES.get((base.__module__, base.__name__))]
        if node is not None
        for field, text in itertools.pairwise(node.body)
        if isinstance(field, ast.AnnAssign) and isinstance(text, ast.Expr)
    }
    assert {field.name for field in dataclasses.fields(cls) if field.name[0] != "_"} <= set(written)
    for lines in written.values():
        assert all(line in head for line in lines)


def test_options_explain_their_fields() -> None:
    assert sorted(OPTIONS - set(CLASSES)) == []
    assert "[N/m]; regularises friction" in inspect.getdoc(StaticsOptions)


def test_class_without_source_keeps_its_summary() -> None:
    made = explain_fields(dataclasses.make_dataclass("Made", ["x"], namespace={"__doc__": "Summary."}))
    assert made.__doc__ == "Summary."
    assert made(x=1).__doc__ == "Summary."


def test_field_docs_are_one_line_each():
    docs = read_field_docs(StaticsOptions)
    assert set(docs) >= {field.name for field in dataclasses.fields(StaticsOptions)}
    assert all(text and "\n" not in text for text in docs.values())
