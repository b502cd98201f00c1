"""What several tests look at."""

from __future__ import annotations

import pytest

from spiraltrunk.cad.components.options import MakeOptions


@pytest.fixture(scope="session")
def options() -> MakeOptions:
    return MakeOptions()
