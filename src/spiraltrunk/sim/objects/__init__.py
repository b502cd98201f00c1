"""Objects to grasp: the catalogue, solids, meshes and MJCF files."""
