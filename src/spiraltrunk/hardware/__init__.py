"""The real robot: motors, servo and arm behind ports, and simulated twins of these devices."""

from spiraltrunk.hardware.plant import HardwarePlant

__all__ = ["HardwarePlant"]
