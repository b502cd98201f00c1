"""Success rates of strategies over randomised trials.

`plan` lists the trials, `run_entry` runs one, `process_pool` distributes them, `row` and `resume_log` store them,
`summary` and `tables` evaluate them, and `run_survey` does it all. Nothing is imported here: a process must limit its
threads first.
"""
