"""Files that are there whole or not at all."""

from __future__ import annotations

import secrets
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def write_draft(path: str | Path) -> Iterator[Path]:
    """A path to write to, put in place of ``path`` at the end of the block, or removed where the block raises.

    The draft lies in the same folder, which is made where it is missing, and ends alike, as writers choose their format
    by the ending.
    """
    target = Path(path)
    target.parent.mkdir(parents=True, exist_ok=True)
    draft = target.parent / f".{secrets.token_hex(8)}{target.suffix}"
    try:
        yield draft
        draft.replace(target)
    except BaseException:
        draft.unlink(missing_ok=True)
        raise
