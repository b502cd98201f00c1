"""Compensation of the arm's lag while the trunk curls: the tensions follow the base, which comes late.

The model has a base position for each ventral pull. The measured base follows its commands by about `LAG`, the cables
at once. Without compensation the trunk had curled before the base was there, by up to 10 mm, so that the tail pulled
the object towards the base before the palm stood behind it. With it, 3 mm were left (simulated trials).
"""

from __future__ import annotations

import numpy as np

from spiraltrunk.control.plant import CONTROL_PERIOD

LAG = 0.10
"""Delay of the measured base behind its command [s] (ours): at 70 mm/s it was 5 to 9 mm behind in simulated trials."""
DELAYED = ("touch", "curl", "tighten")
"""Actions in which the tensions are delayed. Tension is constant in the first of them."""

Tensions = tuple[np.ndarray, ...]
"""Planned tensions of the last periods, the oldest first, each of shape (n_cable,) [N]."""


def delay_tension(recent: Tensions, action: str, planned: np.ndarray) -> tuple[Tensions, np.ndarray]:
    """Planned tensions to remember, and the tension of this period: that planned before `LAG`, shape (n_cable,) [N].

    Args:
        recent: what was remembered in the period before.
        action: name of the present move.
        planned: tension of the present move at this time, shape (n_cable,) [N].
    """
    if action not in DELAYED:
        return (), planned
    recent = (*recent, planned)[-round(LAG / CONTROL_PERIOD) - 1 :]
    return recent, recent[0]
