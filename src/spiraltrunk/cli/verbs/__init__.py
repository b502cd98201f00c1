"""One module or folder a verb: its arguments, and what it does."""
