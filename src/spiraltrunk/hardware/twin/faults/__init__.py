"""Faults of a twin: of its bus, its motors, its drums and its cables."""

from spiraltrunk.hardware.twin.faults.catalogue import FAULTS, build_fault, describe_fault
from spiraltrunk.hardware.twin.faults.device_fault import DeviceFault
from spiraltrunk.hardware.twin.faults.faulty_bus import FaultyBus
from spiraltrunk.hardware.twin.faults.frame_fault import Direction, FrameFault
from spiraltrunk.hardware.twin.faults.injector import FaultInjector

__all__ = [
    "FAULTS",
    "DeviceFault",
    "Direction",
    "FaultInjector",
    "FaultyBus",
    "FrameFault",
    "build_fault",
    "describe_fault",
]
