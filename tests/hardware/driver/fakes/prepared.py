"""Copies of robots in simulated time: homing takes seconds, and a copy of what is homed goes on as that does."""

from __future__ import annotations

import copy
import copyreg
import importlib
import struct
import threading
from collections.abc import Callable, Hashable
from types import ModuleType
from typing import Any
from unittest import mock

from spiraltrunk.design.presets import PAPER
from spiraltrunk.workflows.drive.twin.twin_robot import TwinRobot

_REDUCERS = {
    ModuleType: lambda module: (importlib.import_module, (module.__name__,)),
    struct.Struct: lambda layout: (struct.Struct, (layout.format,)),
    type(threading.RLock()): lambda lock: (threading.RLock, ()),
}
"""How what Python does not copy by itself is made again."""

_PREPARED: dict[Hashable, Any] = {}


def copy_robot(robot: Any) -> Any:
    """A robot of its own in the same state."""
    with mock.patch.dict(copyreg.dispatch_table, _REDUCERS):
        copied = copy.deepcopy(robot, {id(PAPER): PAPER})
    motors = copied.motors if isinstance(copied, TwinRobot) else copied.twin
    if motors.cells is not None:
        motors.cells._read_tensions = lambda: motors.tensions  # A function is not copied.
    return copied


def prepare_once(robot: Any, key: Hashable, prepare: Callable[[], None]) -> None:
    """Prepare a robot that has not run yet, in place; ``key`` says what its like has in common."""
    if robot.clock.now() > 0.0:
        prepare()
        return
    if key not in _PREPARED:
        prepare()
        _PREPARED[key] = copy_robot(robot)
        return
    vars(robot).update(vars(copy_robot(_PREPARED[key])))
