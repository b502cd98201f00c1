"""Success rates of strategies over randomised trials.

`plan` lists the trials, `run_entry` runs one, `row` and `resume_log` store them, `summary` and `tables` evaluate them,
and `run_survey` does it all. `merge` makes one survey of its shards, `compare` tells where two differ.
"""
