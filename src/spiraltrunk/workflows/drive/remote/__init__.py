"""A robot in a process of its own, told what to do over a pipe, and safe when whoever tells it is gone."""
