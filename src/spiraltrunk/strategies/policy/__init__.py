"""Learned policies as strategies: a NumPy forward pass of networks from a file, without the package that trained it."""
