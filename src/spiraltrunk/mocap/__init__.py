"""The judge: recordings of motion capture become static shapes, and shapes are held against a model."""
