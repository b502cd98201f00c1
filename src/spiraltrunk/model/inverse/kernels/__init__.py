"""Compiled laws of the inverse model: scalar code for Numba, one target at a time, without checks."""

from pathlib import Path
from typing import Any

from spiraltrunk.model.jit import compiler, hash_files
from spiraltrunk.model.statics.kernels.newton_calls import SHARED

_MODEL = Path(__file__).parents[2]

STAMP = hash_files([*_MODEL.glob("statics/kernels/**/*.py"), *_MODEL.glob("inverse/kernels/*.py")])
"""Digest of the sources that the machine code on disc was compiled from: these kernels and those they call."""

compiled: Any = compiler(STAMP, owns_arrays=False)
"""How a kernel is compiled."""

calling: Any = compiler(STAMP, calls=SHARED)
"""How the kernel is compiled that Python calls."""

owning: Any = compiler(STAMP)
"""How a kernel is compiled that makes or returns arrays."""
