"""The trunk in static equilibrium: elastic joints, weight, loads, cables with friction."""

from spiraltrunk.model.statics.equilibrium import SHUT, StaticsOptions, solve
from spiraltrunk.model.statics.loads import Creep, Loads

__all__ = ["SHUT", "Creep", "Loads", "StaticsOptions", "solve"]
