"""Where the robot is: shapes and cable lengths from joint bends, pulls and gravity.

Those that compile their laws load Numba, so they are loaded when used.
"""

from importlib import import_module
from types import ModuleType

from spiraltrunk.model import cables, transforms

__all__ = ["cables", "transforms"]

_COMPILED = ("inverse", "jacobians", "reference", "statics", "workspace")


def __getattr__(name: str) -> ModuleType:
    if name in _COMPILED:
        return import_module(f"{__name__}.{name}")
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
