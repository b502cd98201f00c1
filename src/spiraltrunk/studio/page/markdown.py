"""Text of a person within markdown."""

from __future__ import annotations

import re

_SPECIAL = re.compile(r"[\\`*_{}\[\]()<>#|~&:@!]")


def escape_markdown(text: str) -> str:
    """The text in one line, of which viser's markdown renders no character as markup, link or HTML."""
    return _SPECIAL.sub(r"\\\g<0>", " ".join(text.split()))
