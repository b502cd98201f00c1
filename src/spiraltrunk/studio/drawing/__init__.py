"""What tabs draw in the scene."""
