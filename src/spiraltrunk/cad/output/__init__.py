"""From parts to files: catalogue, solids and meshes, bill of materials, assembly guide."""
