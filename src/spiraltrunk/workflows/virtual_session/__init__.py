"""A session of motion capture without a laboratory: a trunk that is off its design, played and filmed in simulation.

What comes out is never a measurement, and every file says so.
"""
