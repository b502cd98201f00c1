"""Equations as inline SVG, typeset by matplotlib's mathtext: no network, no JavaScript, and right in dark mode too."""

from __future__ import annotations

import re
from functools import cache
from html import escape
from typing import Any

from docutils import nodes
from matplotlib.font_manager import FontProperties
from matplotlib.mathtext import MathTextParser
from matplotlib.path import Path
from matplotlib.textpath import TextPath
from sphinx.application import Sphinx

SIZE = 100.0
"""Size at which glyphs are laid out; the page's font size is 1 em of it."""

SCALE = 1.08
"""Size of equations over that of the text around them."""

_LETTER = {Path.MOVETO: "M", Path.LINETO: "L", Path.CURVE3: "Q", Path.CURVE4: "C", Path.CLOSEPOLY: "Z"}


@cache
def draw(tex: str) -> str:
    """One line of TeX, as far as mathtext knows it, as an SVG element that sits on the text's baseline."""
    prop = FontProperties(size=SIZE, math_fontfamily="stix")
    text = f"${tex}$"
    width, height, depth, *_ = MathTextParser("path").parse(text, dpi=72, prop=prop)
    path = TextPath((0, 0), text, size=SIZE, prop=prop)
    em, pad = SCALE / SIZE, 4.0
    box = f"{-pad:.0f} {-height - pad + depth:.1f} {width + 2 * pad:.1f} {height + 2 * pad:.1f}"
    style = f"width:{(width + 2 * pad) * em:.3f}em;height:{(height + 2 * pad) * em:.3f}em;"
    style += f"vertical-align:{-(depth + pad) * em:.3f}em"
    return (
        f'<svg class="mathtext" role="img" aria-label="{escape(tex)}" viewBox="{box}" style="{style}">'
        f'<path d="{_trace(path)}"/></svg>'
    )


def _trace(path: Path) -> str:
    parts = []
    for points, code in path.iter_segments(curves=True, simplify=False):
        pairs = " ".join(f"{x:.1f} {-y:.1f}" for x, y in points.reshape(-1, 2))
        parts.append("Z" if code == Path.CLOSEPOLY else _LETTER[code] + pairs)
    return "".join(parts)


def _clean(tex: str) -> str:
    return re.sub(r"\s+", " ", tex).strip()


def visit_inline(self: Any, node: nodes.math) -> None:
    """Write an equation within a line."""
    self.body.append(draw(_clean(node.astext())))
    raise nodes.SkipNode


def visit_block(self: Any, node: nodes.math_block) -> None:
    """Write one or more equations on lines of their own."""
    lines = [
        draw(_clean(line).replace(r"\frac", r"\dfrac")) for line in re.split(r"\\\\", node.astext()) if line.strip()
    ]
    self.body.append('<div class="math-block">' + "".join(f"<div>{line}</div>" for line in lines) + "</div>")
    raise nodes.SkipNode


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the renderer."""
    app.add_html_math_renderer("mathtext_svg", (visit_inline, None), (visit_block, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
