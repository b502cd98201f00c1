"""Directives that print what the package holds: the catalogue of objects, a preset as a design file."""

from __future__ import annotations

from typing import Any

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

from spiraltrunk.design import format_design, presets
from spiraltrunk.sim.objects.catalogue import CATALOGUE


class Catalogue(SphinxDirective):
    """Names and measures of the objects that are known by name."""

    def run(self) -> list[nodes.Node]:
        """Parse a table."""
        rows = "\n".join(f"| `{name}` | `{measures}` |" for name, measures in CATALOGUE.items())
        return self.parse_text_to_nodes(f"| name | measures |\n|---|---|\n{rows}\n")


class DesignFile(SphinxDirective):
    """A preset in TOML."""

    required_arguments = 1

    def run(self) -> list[nodes.Node]:
        """The file's text."""
        text = format_design(presets.get(self.arguments[0]))
        return [nodes.literal_block(text, text, language="toml")]


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the directives."""
    app.add_directive("catalogue", Catalogue)
    app.add_directive("design-file", DesignFile)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
