"""Mesh files: read, checked and repaired."""
