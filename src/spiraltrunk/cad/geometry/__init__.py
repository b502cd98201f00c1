"""Geometry of parts: constructive solid geometry, the OCC kernel, meshes."""
