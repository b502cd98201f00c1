"""Drawings in the scene that several tabs share."""
