"""Checks of parts: printability, assembly, self-collision when curled, agreement with the design."""
