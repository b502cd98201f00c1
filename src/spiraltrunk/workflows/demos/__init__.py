"""Demonstrations: trials of a survey that are recorded, as data sets for learning.

`options` says what is recorded and how it is written, `recording` records trials, each in a file of its own, `dataset`
writes them in a format of robot learning, and `run_demos` does it all.
"""
