"""Pushes along the ground with the trunk rolled up: kick and sweep."""
