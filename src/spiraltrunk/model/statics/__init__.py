"""The trunk in static equilibrium: elastic joints, weight, loads, cables with friction."""

from spiraltrunk.model.statics.equilibrium import SHUT, StaticsOptions, solve
from spiraltrunk.model.statics.loads import Loads, QuasiStatic

__all__ = ["SHUT", "Loads", "QuasiStatic", "StaticsOptions", "solve"]
