"""Names in docstrings lead to where a thing is documented: under the name by which it is imported.

A type is annotated as ``spiraltrunk.design.trunk.TrunkDesign`` and documented as ``spiraltrunk.design.TrunkDesign``; a
docstring calls it ```TrunkDesign```. What is documented nowhere, such as a private function, stays plain code.
"""

from __future__ import annotations

from typing import Any

from docutils import nodes
from sphinx.addnodes import pending_xref
from sphinx.application import Sphinx
from sphinx.environment import BuildEnvironment
from sphinx.util.nodes import make_refnode


def resolve(app: Sphinx, env: BuildEnvironment, node: pending_xref, contnode: nodes.Element) -> nodes.Node | None:
    """The one documented thing that ends in the same name, nearest to the module that refers to it."""
    if node.get("refdomain") != "py":
        return None
    objects = env.get_domain("py").objects
    last = node["reftarget"].rpartition(".")[2]
    found = [name for name in objects if name.rpartition(".")[2] == last and name.startswith("spiraltrunk")]
    if not found:
        return contnode
    here = node.get("py:module") or ""
    best = max(found, key=lambda name: (len(_shared(name, here)), len(_shared(name, node["reftarget"])), -len(name)))
    entry = objects[best]
    return make_refnode(app.builder, node["refdoc"], entry.docname, entry.node_id, contnode, best)


def _shared(name: str, other: str) -> list[str]:
    parts = []
    for a, b in zip(name.split("."), other.split("."), strict=False):
        if a != b:
            break
        parts.append(a)
    return parts


def setup(app: Sphinx) -> dict[str, Any]:
    """Listen for names that Sphinx itself does not find."""
    app.connect("missing-reference", resolve)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
