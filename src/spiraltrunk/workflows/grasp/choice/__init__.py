"""Choice of a strategy: what each candidate says of a task, the ranking, and further tries after a failed one."""
