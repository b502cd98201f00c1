"""Kinematics: frames, cable lengths and shapes from joint angles, without forces."""
