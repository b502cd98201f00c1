"""The trunk in static equilibrium: elastic joints, weight, loads, cables with friction."""

from spiraltrunk.model.statics.equilibrium import SHUT, StaticsOptions, solve
from spiraltrunk.model.statics.loading_path import LoadingPath, load_along
from spiraltrunk.model.statics.loads import Loads, QuasiStatic

__all__ = ["SHUT", "LoadingPath", "Loads", "QuasiStatic", "StaticsOptions", "load_along", "solve"]
