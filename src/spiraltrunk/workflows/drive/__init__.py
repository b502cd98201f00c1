"""Driving the robot: strategies, steps of a protocol and single moves on motors and arm, or on their twins."""
