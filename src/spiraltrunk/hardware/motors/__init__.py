"""Motors and servo: their commands and their feedback."""
