"""Data sets of robot learning, written from episodes."""
