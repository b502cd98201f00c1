"""Twins of the devices: they answer on the same buses, behave, and fail on request."""
