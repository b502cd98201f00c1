"""Inverse model: cables for a tip, for a direction of the tip, for a whole shape, and the tips that can be reached."""

from spiraltrunk.model.inverse.multistart import InverseOptions
from spiraltrunk.model.inverse.solve import curl, follow, solve

__all__ = ["InverseOptions", "curl", "follow", "solve"]
