"""Safety: states, limits, and the faults that end motion."""
