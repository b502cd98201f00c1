"""How often a strategy works: many drawn trials, counted.

`plan` says which trials there are, `work` is one of them, `pool` runs them in processes, `row` is what one leaves,
`folder` keeps the rows, `counts` and `tables` tell them, and `engine` does it all. Nothing is imported here: a process
sets its threads first.
"""
