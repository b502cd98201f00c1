"""Files: written whole or not at all, read line by line, results as strict JSON."""
