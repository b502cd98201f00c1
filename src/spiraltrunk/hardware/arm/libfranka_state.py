"""State, mode and errors of an arm, as both libraries over libfranka give them."""

from __future__ import annotations

from typing import Any

import numpy as np

from spiraltrunk.hardware.arm.arm_port import ArmState

_MODES = {0: "other", 3: "guiding: a person moves it", 4: "reflex", 5: "user stop pressed", 6: "error recovery"}
"""Modes in which an arm follows nothing (libfranka, enum class RobotMode); 1 is idle and 2 moves."""


def read_libfranka_state(state: Any, acceleration: np.ndarray | None = None) -> ArmState:
    """State of an arm from `franka::RobotState` as panda-python and franky show it; time by the robot's clock.

    Torques are those of the link-side sensors, tau_J, gravity included.
    """
    position = np.array(state.q, float)
    return ArmState(
        time=float(state.time.to_sec()),
        position=position,
        velocity=np.array(state.dq, float),
        acceleration=np.zeros_like(position) if acceleration is None else np.array(acceleration, float),
        torque=np.array(state.tau_J, float),
        error=_describe_error(state),
    )


def _describe_error(state: Any) -> str | None:
    """Names of the errors that are set, and the mode; None for an arm that is idle or moves without error."""
    mode = int(state.robot_mode)
    names = _list_errors(state.current_errors)
    if mode == 4:  # What aborted the motion may already be cleared.
        names = names or _list_errors(state.last_motion_errors)
    where = [_MODES[mode]] if mode in _MODES else []
    return f"the arm reports {', '.join([*where, *names])}" if where or names else None


def _list_errors(errors: Any) -> list[str]:
    """Names of the flags that are set; franky's object is true even when none is, so each is asked."""
    return [name for name in dir(errors) if not name.startswith("_") and getattr(errors, name) is True]
