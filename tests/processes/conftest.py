"""Work for processes."""

from __future__ import annotations

import importlib
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import pytest

FAKES = Path(__file__).parent / "fakes"


@pytest.fixture(scope="session")
def fakes() -> Iterator[ModuleType]:
    """A module that processes find as well, as they start with this one's path."""
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(FAKES)
        yield importlib.import_module("pool_fakes")
