"""Compiled laws of the equilibrium: scalar code for Numba, one trunk at a time, without checks of the inputs."""

from pathlib import Path
from typing import Any

from spiraltrunk.model.jit import compiler, hash_files

STAMP = hash_files(Path(__file__).parent.rglob("*.py"))
"""Digest of the sources that the machine code on disc was compiled from."""

compiled: Any = compiler(STAMP, owns_arrays=False)
"""How a kernel is compiled."""

owning: Any = compiler(STAMP)
"""How a kernel is compiled that makes or returns arrays."""
