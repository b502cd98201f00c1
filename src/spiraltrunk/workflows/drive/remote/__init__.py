"""A robot in a process of its own that gets requests over a pipe; it becomes safe when the sender is gone."""
