"""Docstrings of a dataclass's fields, shown by `help`."""

from __future__ import annotations

import ast
import functools
import inspect
import itertools
import textwrap
from typing import TypeVar, final

_C = TypeVar("_C", bound=type)


@final
class _Docstring:
    """Docstring of a class, to which those of its fields are added when it is asked for.

    Python keeps no docstrings of fields: they are read from the source.
    """

    def __init__(self, summary: str) -> None:
        self.summary = summary

    def __get__(self, instance: object, owner: type) -> str:
        return _explain(owner, self.summary)


def _read_body(cls: type) -> list[ast.stmt]:
    """Statements of a class; none where its source cannot be read."""
    try:
        written = ast.parse(textwrap.dedent(inspect.getsource(cls))).body[0]
    except (OSError, TypeError, SyntaxError):
        return []
    return written.body if isinstance(written, ast.ClassDef) else []


@functools.cache
def read_field_docs(cls: type) -> dict[str, str]:
    """Docstring of each field of a class and its bases, on one line; none where the source cannot be read."""
    return {
        ast.unparse(field.target): " ".join(str(text.value.value).split())
        for field, text in itertools.chain(*(itertools.pairwise(_read_body(base)) for base in reversed(cls.__mro__)))
        if isinstance(field, ast.AnnAssign) and isinstance(text, ast.Expr) and isinstance(text.value, ast.Constant)
    }


@functools.cache
def _explain(owner: type, summary: str) -> str:
    lines = [inspect.cleandoc(summary), "", "Fields:"]
    for field, text in itertools.chain(*(itertools.pairwise(_read_body(base)) for base in reversed(owner.__mro__))):
        if isinstance(field, ast.AnnAssign) and isinstance(text, ast.Expr) and isinstance(text.value, ast.Constant):
            lines.append(f"    {ast.unparse(field.target)}: {ast.unparse(field.annotation)}")
            lines.append(textwrap.indent(inspect.cleandoc(str(text.value.value)), " " * 8))
    return "\n".join(lines) if len(lines) > 3 else summary


def explain_fields(cls: _C) -> _C:
    """Class decorator, the outermost: `help` shows meaning and unit of each field, as written below it.

    Not for abstract classes and their subclasses: `help` does not ask their metaclass for the docstring.
    """
    if cls.__doc__:  # python -OO leaves docstrings out.
        cls.__doc__ = _Docstring(cls.__doc__)  # type: ignore[assignment]
    return cls
