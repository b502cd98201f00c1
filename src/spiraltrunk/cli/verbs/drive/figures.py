"""Figures as the tables of ``spiraltrunk drive`` show them."""

from __future__ import annotations

import math


def format_figure(figure: float, digits: int) -> str:
    """A figure with so many decimals, zero without a sign; "-" for one that is not finite."""
    return f"{round(figure, digits) + 0.0:.{digits}f}" if math.isfinite(figure) else "-"
