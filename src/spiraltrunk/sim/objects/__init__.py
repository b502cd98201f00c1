"""Objects to grasp: the catalogue, solids by their measures, meshes and MJCF files."""
