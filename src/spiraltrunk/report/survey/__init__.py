"""Pictures of a survey: rates with intervals, and the map over size and mass."""
