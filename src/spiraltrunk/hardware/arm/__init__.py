"""Arm: one port over the drivers of the robot arm."""
