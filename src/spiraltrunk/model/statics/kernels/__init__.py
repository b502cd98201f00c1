"""Compiled laws of the equilibrium: scalar code for Numba, one trunk at a time, no checks (those are made outside)."""

from pathlib import Path
from typing import Any

from spiraltrunk.model.jit import compiler, hash_files

STAMP = hash_files(Path(__file__).parent.glob("*.py"))
"""What the machine code on disc must have been compiled from."""

compiled: Any = compiler(STAMP, owns_arrays=False)
"""How a kernel is compiled."""

owning: Any = compiler(STAMP)
"""How one is that makes or returns arrays."""
