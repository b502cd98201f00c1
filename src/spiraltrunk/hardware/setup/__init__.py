"""What a robot is set up with: its file, its ports, the relay in its supply, and poses of its user."""
