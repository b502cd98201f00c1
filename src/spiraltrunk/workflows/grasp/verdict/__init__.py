"""Verdict on a trial: success, and the physical cause of a failure."""
