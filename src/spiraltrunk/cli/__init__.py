"""The command line: `entry` finds the verb, one module a verb adds its arguments and does the work."""

from spiraltrunk.cli.entry import main

__all__ = ["main"]
