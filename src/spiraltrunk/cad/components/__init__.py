"""Purchased components and manufacturing options: fasteners, motors, printer."""
