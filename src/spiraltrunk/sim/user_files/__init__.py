"""Files that users bring: read within limits, and compiled in a process of its own before anything relies on them."""
