"""Vectors for learning: observations as numbers in finite boxes, actions in [-1, 1] as commands and back."""

from spiraltrunk.control.encoding.actions import (
    ArmJoints,
    EncodedAction,
    action_names,
    action_size,
    decode_action,
    decode_joints,
    encode_command,
    interpolate_command,
)
from spiraltrunk.control.encoding.control_mode import ControlMode, parse_control_mode, read_periods
from spiraltrunk.control.encoding.observations import (
    agent_bounds,
    agent_names,
    encode_agent,
    encode_environment,
    environment_bounds,
    environment_names,
)
from spiraltrunk.control.encoding.setpoint import (
    Setpoint,
    begin_setpoint,
    follow_action,
    next_velocity,
    restart_setpoint,
)

__all__ = [
    "ArmJoints",
    "ControlMode",
    "EncodedAction",
    "Setpoint",
    "action_names",
    "action_size",
    "agent_bounds",
    "agent_names",
    "begin_setpoint",
    "decode_action",
    "decode_joints",
    "encode_agent",
    "encode_command",
    "encode_environment",
    "environment_bounds",
    "environment_names",
    "follow_action",
    "interpolate_command",
    "next_velocity",
    "parse_control_mode",
    "read_periods",
    "restart_setpoint",
]
