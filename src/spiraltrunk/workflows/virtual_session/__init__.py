"""Virtual motion-capture session: a simulated trunk that deviates from its design, recorded by simulated cameras.

Its takes are synthetic, and every file says so.
"""
