"""The tab *Grasp*: pickers, the run as it is computed, its timeline and plots, and what can be saved of it."""
