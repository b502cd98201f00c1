"""The real robot: motors, servo and arm behind ports, with twins that answer, behave and fail like the devices."""

from spiraltrunk.hardware.plant import HardwarePlant

__all__ = ["HardwarePlant"]
