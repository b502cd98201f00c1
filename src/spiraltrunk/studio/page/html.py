"""Pieces of HTML that the tabs' texts are made of."""

from __future__ import annotations

from html import escape

BLOCK = '<div style="font-size: 0.8rem; line-height: 1.45; padding: 0 0.75em 0.4em 0.75em">{}</div>'
"""Frame of a text under the controls."""


def format_mark(color: str, text: str, *, radius: str = "2px") -> str:
    """A square of a CSS colour, with corners of ``radius``, and what it stands for."""
    square = f"display: inline-block; width: 0.75em; height: 0.75em; border-radius: {radius}; background: {color}"
    return (
        f'<span style="white-space: nowrap; margin-right: 0.6em"><span style="{square}"></span> {escape(text)}</span>'
    )


def format_color(color: tuple[int, int, int]) -> str:
    """A colour, red, green and blue of 0 to 255, as CSS."""
    return "rgb({}, {}, {})".format(*color)
