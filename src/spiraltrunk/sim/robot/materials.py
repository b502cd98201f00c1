"""Contact and colour constants of all bodies of a scene."""

SOLREF = [0.004, 1.0]
"""Time constant [s] and damping ratio [-] of contacts, equal for trunk and objects; MuJoCo averages unequal ones."""

SOLIMP = [0.95, 0.99, 0.001, 0.5, 2.0]
"""Impedance of contacts: from 0.95 to 0.99 over 1 mm of penetration."""

FRICTION = [1.0, 0.005, 1e-4]
"""Friction of trunk and fingers: sliding [-], MuJoCo's default, torsional and rolling [m], of which contacts of three
dimensions use none. In contacts with objects and supports theirs counts, which have a higher priority."""

TRUNK_COLORS = ([0.50, 0.55, 0.62, 1.0], [0.58, 0.63, 0.70, 1.0])
"""Alternating colours of the sections."""
