"""Compiled laws of the equilibrium: scalar code for Numba, one trunk at a time, no checks (those are made outside)."""

from pathlib import Path
from typing import Any

from spiraltrunk.model.compiled import compiler, hash_files

STAMP = hash_files(Path(__file__).parent.glob("*.py"))
"""What the machine code on disc must have been compiled from."""

compiled: Any = compiler(STAMP)
"""How every kernel is compiled."""
