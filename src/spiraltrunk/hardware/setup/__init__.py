"""Setup of a robot: its robot file, its ports, the relay in its supply, and saved poses."""
