"""A table reads as it is printed."""

from __future__ import annotations

from spiraltrunk.report import format_table


def test_names_and_values_are_aligned() -> None:
    rows = [("Length", "0.353 m"), ("Base width", "52.1 mm"), ("",), ("Mass", "0.19 kg")]
    assert format_table(rows, title="paper", indent=2) == (
        "paper\n"
        "  Length      0.353 m\n"
        "  Base width  52.1 mm\n"
        "\n"
        "  Mass        0.19 kg"
    )  # fmt: skip


def test_header_is_underlined() -> None:
    assert format_table([("b", "0.16")], header=("Name", "Value")) == (
        "Name  Value\n"
        "----  -----\n"
        "b     0.16"
    )  # fmt: skip


def test_line_breaks_within_a_cell_do_not_break_the_table() -> None:
    assert format_table([("a\nb", " 1  m ")]) == "a b  1 m"


def test_empty_table_is_empty() -> None:
    assert format_table([]) == ""
