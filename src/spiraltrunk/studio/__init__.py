"""The studio: one browser page over design, shape, grasp, measurement and robot.

It holds no physics of its own: whatever a control does, a command or a Python call does too.
"""
