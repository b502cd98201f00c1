"""The command line: `entry` finds the verb, one module a verb adds its arguments and does the work."""

from __future__ import annotations

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Sequence


def main(argv: Sequence[str] | None = None) -> int:
    """Run a verb and return the exit code; `signals` can be imported before the verbs are."""
    from spiraltrunk.cli.entry import main

    return main(argv)
