"""Relaxation of a simulated trunk to its equilibrium, for comparison with the models."""
