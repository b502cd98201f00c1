"""Whether the trunk's base leans as it was set: the one thing that tells a wrong run, tilt or axis convention."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from spiraltrunk.errors import TakeError
from spiraltrunk.mocap.protocol.protocol import Run
from spiraltrunk.mocap.session.sections import HeldShape
from spiraltrunk.mocap.signal.registration import mean_rotation

_LEANS = math.radians(2.0)
"""Angle between the base's axis as set and as seen from which on it is told [rad] (ours)."""

_WRONG = math.radians(10.0)
"""The same from which on the recording is refused: nobody sets a tilt so badly [rad] (ours)."""


def check_base(held: Sequence[HeldShape], run: Run, source: str) -> list[str]:
    """A note where the base's rigid body leans otherwise than set; nothing where its orientation was not seen.

    Raises:
        TakeError: where it leans so much otherwise that tilt, axes or run must be wrong.
    """
    rotation = mean_rotation(np.array([shape.base_rotation for shape in held]))
    if not np.isfinite(rotation).all():
        return []
    lean = math.asin(float(np.clip(-rotation[1, 0], -1.0, 1.0)))
    set_to = math.asin(math.sin(run.theta_0))
    seen, wanted = (round(math.degrees(angle), 1) + 0.0 for angle in (lean, set_to))
    told = f"its axis is {seen:.1f} deg below the horizontal, not {wanted:.1f}"
    if abs(lean - set_to) > _WRONG:
        tilt = f"tilt_deg = {90 - math.degrees(run.theta_0):g}"
        check = (
            f"check --axes, whether the recording is of run {run.name!r}, its {tilt} in the protocol, and that the "
            "body's x lies along the base axis (--rotations ignore does without it)"
        )
        limit = f"{math.degrees(_WRONG):g} deg"
        raise TakeError(
            f"the base leans otherwise than set: {told}; allowed: at most {limit} off; {check}", file=source
        )
    return [f"the base leans otherwise than set: {told}"] if abs(lean - set_to) > _LEANS else []
