"""CAD: every part of the robot as a solid, checked for printing."""
