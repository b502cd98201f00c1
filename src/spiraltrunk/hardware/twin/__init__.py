"""Twins: simulated motors, servo and board on the same buses as the devices, with faults on request."""
