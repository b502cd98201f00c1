"""Pictures of a trial: plots over time, film strip and video."""
