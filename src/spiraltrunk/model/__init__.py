"""Where the robot is: shapes and cable lengths from joint bends."""

from spiraltrunk.model import cables, transforms

__all__ = ["cables", "transforms"]
