"""Meshes: read, repaired, described, and the poses in which they rest."""
