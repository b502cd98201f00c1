"""Recording of trials: every message between plant and strategy, the simulator's states and pictures."""
