"""Argument types, and the parser of a verb."""

from __future__ import annotations

import argparse
import math
import re
from collections.abc import Callable
from typing import Any, NoReturn, final

from spiraltrunk.cli.output import Answer, UsageError, quote

_MOST_SEED = 2**32 - 1

_NEGATIVE = re.compile(r"-(\d+\.?\d*|\.\d+)(e[-+]?\d+)?$", re.IGNORECASE)
"""Negative numbers, which are no options; argparse itself does not recognise -9e1."""


class Parser(argparse.ArgumentParser):
    """Argument parser that raises instead of printing its usage, and reads negative numbers with exponents."""

    def __init__(self, *args: Any, **options: Any) -> None:
        super().__init__(*args, **options)
        self._negative_number_matcher = _NEGATIVE

    def error(self, message: str) -> NoReturn:
        """Refuse the arguments.

        Raises:
            UsageError: with the message and a hint to the help.
        """
        command = self.prog.replace(" [DESIGN]", "")  # Of the actions of drive, which follow it.
        raise UsageError(f"{message}; see {command} --help")

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """Refuse unknown arguments where they stand, so that the hint names the verb's own help."""
        known, unknown = super().parse_known_args(args, namespace)
        if unknown:
            self.error(f"unrecognized arguments: {' '.join(unknown)}")
        return known, unknown


@final
class Typed(float):
    """A number with the text that was typed for it."""

    text: str

    def __new__(cls, text: str) -> Typed:
        number = super().__new__(cls, text)
        number.text = text
        return number


def add_parser(
    verbs: Any, name: str, run: Callable[[argparse.Namespace], Answer], what: str
) -> argparse.ArgumentParser:
    """The parser of a new verb that ``run`` executes."""
    parser: argparse.ArgumentParser = verbs.add_parser(name, help=what, description=what, allow_abbrev=False)
    parser.add_argument("--json", action="store_true", help="print one JSON object on standard output, nothing else")
    parser.set_defaults(run=run)
    return parser


def read_number(text: str) -> Typed:
    """A finite number, as an argument's type."""
    try:
        value = float(text) if text.isascii() and "_" not in text else math.nan
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError(f"{quote(text)} given; allowed: a finite number")
    return Typed(text.strip())


def read_count(text: str) -> int:
    """A whole number, as an argument's type; its range is for others to check."""
    if not re.fullmatch(r"-?[0-9]{1,10}", text):
        raise argparse.ArgumentTypeError(f"{quote(text)} given; allowed: a whole number of at most 10 digits")
    return int(text)


def read_seed(text: str) -> int:
    """A seed of random numbers, as an argument's type."""
    if not re.fullmatch(r"[0-9]{1,10}", text) or int(text) > _MOST_SEED:
        raise argparse.ArgumentTypeError(f"{quote(text)} given; allowed: a whole number from 0 to {_MOST_SEED}")
    return int(text)


def read_text(text: str) -> str:
    """A non-empty text, as an argument's type."""
    if not text.strip() or "\0" in text:
        raise argparse.ArgumentTypeError(f"{quote(text)} given; allowed: a text that is not empty")
    return text
