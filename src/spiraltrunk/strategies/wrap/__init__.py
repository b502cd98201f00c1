"""Wraps: the whole trunk round an object, hung or standing."""
