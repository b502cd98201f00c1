"""``spiraltrunk completion``: scripts by which shells complete verbs, options, names and files (package shtab)."""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Iterator
from typing import Any

from spiraltrunk.cli.arguments import add_parser
from spiraltrunk.cli.output import DONE, Answer, format_json

SHELLS = ("bash", "zsh", "fish")
"""Shells with a completion script."""

_FILES = {"FILE", "FILE.html", "DIR", "TAKE", "LOG", "PROTOCOL", "BUS"}
"""Metavariables of arguments that are files or folders."""

_BASH = """{name}() {{ compgen -W "{words}" -- "$1"; compgen -f -- "$1"; }}"""
_ZSH = """{name}() {{ _alternative 'names:name:({words})' 'files:file:_files' }}"""


def add_verb(verbs: Any) -> None:
    """Add the verb and its arguments."""
    parser = add_parser(verbs, "completion", _run, "print the completion script of a shell")
    parser.add_argument("shell", choices=SHELLS, help='in bash: eval "$(spiraltrunk completion bash)"')


def _run(arguments: argparse.Namespace) -> Answer:
    import shtab

    words = _list_words()
    for prog, action in _list_arguments(arguments.parser):
        key = "action" if prog.endswith(" drive") and action.dest == "design" else action.dest
        if key in words:
            name = _name(key)
            action.complete = {"bash": name, "zsh": name}
        elif action.metavar in _FILES:
            action.complete = shtab.FILE
    preamble: Any = {  # The package's annotation has a text alone.
        shell: "\n".join(form.format(name=_name(key), words=" ".join(known)) for key, known in words.items())
        for shell, form in (("bash", _BASH), ("zsh", _ZSH))
    }
    script = shtab.complete(arguments.parser, shell=arguments.shell, preamble=preamble)
    # Where nothing is offered, bash completes files, as it does without the script.
    script = script.replace("complete -o bashdefault -F", "complete -o bashdefault -o default -F")
    return DONE, format_json({"shell": arguments.shell, "script": script}) if arguments.json else script


def _name(key: str) -> str:
    """Name of a shell's function; with "_file" in it shtab lets bash append a slash to folders."""
    return f"_spiraltrunk_{key}_file"


def _list_words() -> dict[str, Iterable[str]]:
    """Names that an argument takes besides files, by its destination."""
    from spiraltrunk.cli.verbs.drive import ACTIONS
    from spiraltrunk.design import presets
    from spiraltrunk.sim.objects.catalogue import CATALOGUE
    from spiraltrunk.strategies import NAMES

    strategies = (*NAMES, "auto")
    return {
        "design": presets.NAMES, "preset": presets.NAMES, "action": (*ACTIONS, *presets.NAMES), "object": CATALOGUE,
        "strategy": strategies, "strategies": strategies,
    }  # fmt: skip


def _list_arguments(parser: argparse.ArgumentParser) -> Iterator[tuple[str, Any]]:
    """Program name and arguments of a parser and of those below it."""
    for action in parser._actions:  # Argparse lists them nowhere else, and shtab reads them so, too.
        if isinstance(action, argparse._SubParsersAction):
            for below in action.choices.values():
                yield from _list_arguments(below)
        else:
            yield parser.prog, action
