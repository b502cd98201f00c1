"""Tilt of the recorded base against the protocol: detects a wrong run, tilt or axis convention."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from spiraltrunk.errors import TakeError
from spiraltrunk.mocap.protocol.protocol import Run
from spiraltrunk.mocap.session.sections import HeldShape
from spiraltrunk.mocap.signal.registration import mean_rotation

_NOTED = math.radians(2.0)
"""Difference between set and recorded tilt from which it is noted [rad] (ours)."""

_REFUSED = math.radians(10.0)
"""Difference from which the recording is refused [rad] (ours)."""


def check_base(held: Sequence[HeldShape], run: Run, source: str) -> list[str]:
    """A note where the base's rigid body has another tilt than the run; nothing where its orientation was not seen.

    Raises:
        TakeError: where the difference is so large that tilt, axes or run must be wrong.
    """
    rotation = mean_rotation(np.array([shape.base_rotation for shape in held]))
    if not np.isfinite(rotation).all():
        return []
    seen = math.asin(float(np.clip(-rotation[1, 0], -1.0, 1.0)))
    expected = math.asin(math.sin(run.theta_0))
    seen_deg, expected_deg = (round(math.degrees(angle), 1) + 0.0 for angle in (seen, expected))
    reason = f"the base is tilted otherwise than set: its axis is {seen_deg:.1f} deg below the horizontal, not "
    reason += f"{expected_deg:.1f}"
    if abs(seen - expected) > _REFUSED:
        tilt = f"tilt_deg = {90 - math.degrees(run.theta_0):g}"
        advice = (
            f"check --axes, whether the recording is of run {run.name!r}, its {tilt} in the protocol, and that the "
            "body's x lies along the base axis (--rotations ignore does without it)"
        )
        raise TakeError(f"{reason}; allowed: at most {math.degrees(_REFUSED):g} deg off; {advice}", file=source)
    return [reason] if abs(seen - expected) > _NOTED else []
