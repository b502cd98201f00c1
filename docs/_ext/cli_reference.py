"""The directive ``cli-reference``: every verb of ``spiraltrunk`` with its arguments, read from the parser itself."""

from __future__ import annotations

import argparse
import re
from collections.abc import Iterator
from typing import Any

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

from spiraltrunk.cli.entry import _build_parser


def find_verbs(parser: argparse.ArgumentParser) -> dict[str, tuple[argparse.ArgumentParser, str]]:
    """Parser and one line of help of each verb, or of each action of a verb, in the order of the help."""
    verbs = next((action for action in parser._actions if isinstance(action, argparse._SubParsersAction)), None)
    if verbs is None:
        return {}
    told = {choice.dest: choice.help or "" for choice in verbs._choices_actions}
    return {name: (verbs.choices[name], told[name]) for name in verbs.choices}


def format_reference(parser: argparse.ArgumentParser) -> str:
    """The reference as reStructuredText."""
    lines: list[str] = []
    for name, (verb, told) in find_verbs(parser).items():
        lines += ["", f".. _cli-{name}:", ""]
        lines += _format_verb(verb, f"{parser.prog} {name}", told, "=")
        for action, (inner, said) in find_verbs(verb).items():
            lines += ["", *_format_verb(inner, f"{parser.prog} {name} {action}", said, "-")]
    return "\n".join(lines)


def _format_verb(verb: argparse.ArgumentParser, name: str, told: str, underline: str) -> Iterator[str]:
    yield from (name, underline * 60, "", f"{_sentence(told)}", "")
    yield from (".. code-block:: text", "", *(f"   {line}" for line in _usage(verb)), "")
    yield from (f".. program:: {name}", "")
    for group in verb._action_groups:
        yield from _format_group(verb, group)


def _usage(verb: argparse.ArgumentParser) -> list[str]:
    return verb.format_usage().removeprefix("usage: ").rstrip().splitlines()


def _format_group(verb: argparse.ArgumentParser, group: argparse._ArgumentGroup) -> Iterator[str]:
    actions = [
        action
        for action in group._group_actions
        if action.dest != "help" and not isinstance(action, argparse._SubParsersAction)
    ]
    if not actions:
        return
    yield from (f".. rubric:: {_escape(_sentence(group.title or 'arguments').rstrip('.'))}", "")
    formatter = verb._get_formatter()
    for action in actions:
        yield from (f".. option:: {_spell(action, formatter)}", "")
        yield from (f"   {_escape(_sentence(formatter._expand_help(action)))}", "")


def _spell(action: argparse.Action, formatter: argparse.HelpFormatter) -> str:
    default = formatter._get_default_metavar_for_optional(action) if action.option_strings else action.dest
    values = formatter._format_args(action, default) if action.nargs != 0 else ""
    if not action.option_strings:
        return values.strip("[]") if action.nargs == "?" else values
    return ", ".join(f"{option} {values}".strip() for option in action.option_strings)


def _sentence(text: str) -> str:
    text = re.sub(r"\s+", " ", text).strip()
    text = text[:1].upper() + text[1:] if re.match(r"[a-z]+( |,|$)", text) else text
    return text if text.endswith(".") else f"{text}."


def _escape(text: str) -> str:
    """Plain text, options as code."""
    text = re.sub(r"([\\*`|_])", r"\\\1", text)
    return re.sub(r"(?<![\w-])(--[a-z](?:[\w=,.-]*\w)?)", r"``\1``", text)


class CliReference(SphinxDirective):
    """Puts the reference where the directive stands."""

    def run(self) -> list[nodes.Node]:
        """Parse what `format_reference` writes."""
        return self.parse_text_to_nodes(format_reference(_build_parser()), allow_section_headings=True)


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the directive."""
    app.add_directive("cli-reference", CliReference)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
