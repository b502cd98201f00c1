"""How cables are moved unless a person says otherwise, on the command line and on a page."""

TENSION = 20.0
"""Largest tension of each cable [N] (ours): it curls the paper's trunk half."""

SPEED = 0.02
"""Speed of the cable with the longest way [m/s] (ours)."""
