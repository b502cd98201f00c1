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


@functools.cache
def _explain(owner: type, summary: str) -> str:
    try:
        body = ast.parse(textwrap.dedent(inspect.getsource(owner))).body[0]
    except (OSError, TypeError, SyntaxError):  # Without source there is the summary alone.
        return summary
    lines = [inspect.cleandoc(summary), "", "Fields:"]
    statements = body.body if isinstance(body, ast.ClassDef) else []
    for field, text in itertools.pairwise(statements):
        if isinstance(field, ast.AnnAssign) and isinstance(text, ast.Expr) and isinstance(text.value, ast.Constant):
            lines.append(f"    {ast.unparse(field.target)}: {ast.unparse(field.annotation)}")
            lines.append(textwrap.indent(inspect.cleandoc(str(text.value.value)), " " * 8))
    return "\n".join(lines) if len(lines) > 3 else summary


def explain_fields(cls: _C) -> _C:
    """Class decorator, the outermost: `help` shows meaning and unit of each field, as written below it."""
    if cls.__doc__:  # python -OO leaves docstrings out.
        cls.__doc__ = _Docstring(cls.__doc__)  # type: ignore[assignment]
    return cls
