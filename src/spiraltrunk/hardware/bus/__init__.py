"""Buses: frames to and from the motors."""
