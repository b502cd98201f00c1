"""Motors and servo: what they are told and what they answer."""
