"""Recordings of motion capture: Motive CSV, C3D and NatNet, read into takes."""
