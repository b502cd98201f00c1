"""``spiraltrunk completion``: scripts with which shells complete verbs and options, by the package shtab."""

from __future__ import annotations

import argparse
from typing import Any

from spiraltrunk.cli.arguments import add_parser
from spiraltrunk.cli.output import DONE, Answer, format_json

SHELLS = ("bash", "zsh", "fish")
"""Shells with a completion script."""


def add_verb(verbs: Any) -> None:
    """Add the verb and its arguments."""
    parser = add_parser(verbs, "completion", _run, "print the completion script of a shell")
    parser.add_argument("shell", choices=SHELLS, help='in bash: eval "$(spiraltrunk completion bash)"')


def _run(arguments: argparse.Namespace) -> Answer:
    import shtab

    script = shtab.complete(arguments.parser, shell=arguments.shell)
    return DONE, format_json({"shell": arguments.shell, "script": script}) if arguments.json else script
