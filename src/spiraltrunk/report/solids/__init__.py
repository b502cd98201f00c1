"""Pictures of parts: one by one and exploded."""
