"""Recordings compared with a model: figures, pictures and a page."""
