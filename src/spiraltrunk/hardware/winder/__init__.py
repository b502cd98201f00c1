"""Winder: one motor with its drum, which holds a cable's tension and length."""
