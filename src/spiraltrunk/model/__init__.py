"""Models of the trunk: kinematics, the paper's forward model, static equilibrium and inverse.

The models that compile their kernels load Numba, so they are loaded when used.
"""

from importlib import import_module
from types import ModuleType

from spiraltrunk.model.kinematics import cables, frames

__all__ = ["cables", "frames"]

_COMPILED = ("inverse", "reference", "statics")


def __getattr__(name: str) -> ModuleType:
    if name in _COMPILED:
        return import_module(f"{__name__}.{name}")
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
