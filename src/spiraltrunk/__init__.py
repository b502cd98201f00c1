"""From a logarithmic-spiral soft trunk on paper to a machine that grasps like an elephant."""

__version__ = "0.1.0"
