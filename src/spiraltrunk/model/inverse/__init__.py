"""Inverse model: cable tensions for a tip position, a direction or a whole shape; workspace of the tip."""

from spiraltrunk.model.inverse.multistart import InverseOptions
from spiraltrunk.model.inverse.solve import curl, follow, solve

__all__ = ["InverseOptions", "curl", "follow", "solve"]
