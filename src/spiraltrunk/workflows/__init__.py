"""Workflows: one folder for each job that a command or a caller asks for, from inputs to files."""
