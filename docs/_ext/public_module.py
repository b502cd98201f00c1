"""The directive ``public-module``: a table of what a package offers, and each of it in full.

What a package offers is its ``__all__``; without one, the public functions and classes that it defines.
"""

from __future__ import annotations

import importlib
import inspect
from types import ModuleType
from typing import Any

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective


def find_public(module: ModuleType) -> list[str]:
    """Names of what a module offers, submodules left out."""
    names = getattr(module, "__all__", None)
    if names is None:
        names = [name for name, value in vars(module).items() if _is_own(module, name, value)]
    return [name for name in names if not inspect.ismodule(getattr(module, name))]


def _is_own(module: ModuleType, name: str, value: object) -> bool:
    is_code = inspect.isclass(value) or inspect.isfunction(value)
    return is_code and not name.startswith("_") and getattr(value, "__module__", None) == module.__name__


class PublicModule(SphinxDirective):
    """``.. public-module:: NAME``; an indented list of names restricts it to these."""

    required_arguments = 1
    has_content = True

    def run(self) -> list[nodes.Node]:
        """Write the directives of autodoc and autosummary, and parse them."""
        name = self.arguments[0]
        names = [line.strip() for line in self.content if line.strip()]
        chosen = names or find_public(importlib.import_module(name))
        lines = [] if names else [f".. automodule:: {name}", "   :no-members:", ""]
        if len(chosen) > 2:
            lines += [f".. currentmodule:: {name}", ""]
            lines += [".. autosummary::", "   :nosignatures:", "", *(f"   {item}" for item in chosen), ""]
        for item in chosen:
            kind = "class" if inspect.isclass(self._get(name, item)) else "function"
            kind = kind if callable(self._get(name, item)) else "data"
            lines += [f".. auto{kind}:: {name}.{item}", ""]
        return self.parse_text_to_nodes("\n".join(lines))

    def _get(self, module: str, name: str) -> Any:
        return getattr(importlib.import_module(module), name)


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the directive."""
    app.add_directive("public-module", PublicModule)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
