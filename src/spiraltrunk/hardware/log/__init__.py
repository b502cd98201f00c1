"""Log of a run on hardware or twin, readable after a crash."""
