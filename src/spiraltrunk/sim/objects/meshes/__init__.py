"""Mesh files: read, repaired and judged."""
