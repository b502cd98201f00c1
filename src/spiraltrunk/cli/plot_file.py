"""The file of ``--plot``: its format, and whether it may be written."""

from __future__ import annotations

from pathlib import Path

from spiraltrunk.cli.output import UsageError, name_option, quote

PLOTS = (".png", ".svg", ".pdf")
"""Endings of a plot's file."""


def check_plot(file: Path) -> None:
    """Refuse a file of another format, or one that cannot be written or must not be replaced.

    Raises:
        UsageError: with the file and what is allowed.
    """
    if file.suffix.lower() not in PLOTS:
        raise UsageError(f"--plot: {quote(str(file))} given; allowed: a file that ends in {', '.join(PLOTS)}")
    from spiraltrunk.files.output_file import check_output_file

    with name_option("--plot"):
        check_output_file(file, read_format(file))


def read_format(file: Path) -> str:
    """Format of a plot, as its ending says."""
    return file.suffix.lower().removeprefix(".")
