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
from spiraltrunk.control.encoding.control_mode import ControlMode, parse_control_mode
from spiraltrunk.control.encoding.observations import (
    agent_bounds,
    agent_names,
    encode_agent,
    encode_environment,
    environment_bounds,
    environment_names,
)

__all__ = [
    "ArmJoints",
    "ControlMode",
    "EncodedAction",
    "action_names",
    "action_size",
    "agent_bounds",
    "agent_names",
    "decode_action",
    "decode_joints",
    "encode_agent",
    "encode_command",
    "encode_environment",
    "environment_bounds",
    "environment_names",
    "interpolate_command",
    "parse_control_mode",
]
