"""Tab of the robot: who is in control of it, its state, homing, jogging, and strategies on the twin."""
