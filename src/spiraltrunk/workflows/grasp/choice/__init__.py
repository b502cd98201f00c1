"""Choice of a strategy: candidates with their predictions, the ranking, and further tries after a failed one."""
