"""Cables with residual slack between the twin's drums and its trunk."""

from __future__ import annotations

from collections.abc import Sequence
from typing import final

from spiraltrunk.hardware.twin.cable_load import CableLoad
from spiraltrunk.hardware.winder.slack import remove_slack


@final
class SlackLoad(CableLoad):
    """A load that sees less cable wound in than the drums wind: slack is taken up in proportion, see `winder.slack`."""

    def __init__(self, load: CableLoad, slack: Sequence[float], stroke: float) -> None:
        """Put ``slack`` of each cable at the full ``stroke`` [m] before a load."""
        self._load, self._slack, self._stroke = load, tuple(slack), stroke

    def advance(self, wound: Sequence[float], stiffness: Sequence[float], dt: float) -> Sequence[float]:
        """See `CableLoad.advance`."""
        seen = [remove_slack(one, slack, self._stroke) for one, slack in zip(wound, self._slack, strict=True)]
        return self._load.advance(seen, stiffness, dt)
