"""Watches: each looks for one kind of fault, from what a period of control shows it."""
