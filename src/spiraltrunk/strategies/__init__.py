"""Grasping strategies by name, pure and the same on every plant."""

from typing import Any

from spiraltrunk.control.strategy import Status, Strategy
from spiraltrunk.errors import UnknownName
from spiraltrunk.strategies.fingertip.flip_grip import FlipGrip
from spiraltrunk.strategies.fingertip.tip_grip import Pinch, TipGrip
from spiraltrunk.strategies.push.kick import Kick
from spiraltrunk.strategies.push.sweep import Sweep
from spiraltrunk.strategies.wrap.hung import WrapVertical
from spiraltrunk.strategies.wrap.standing import WrapHorizontal, WrapOblique, WrapObliqueLow

_ALL: tuple[type[Strategy[Any]], ...] = (
    WrapVertical, WrapObliqueLow, WrapOblique, WrapHorizontal, Pinch, TipGrip, FlipGrip, Kick, Sweep,
)  # fmt: skip
_STRATEGIES = {strategy.name: strategy for strategy in _ALL}

NAMES = tuple(_STRATEGIES)
"""Names of the strategies."""


def get(name: str) -> Strategy[Any]:
    """The strategy called ``name``, with its default options.

    Raises:
        UnknownName: lists the names.
    """
    if not isinstance(name, str) or name not in _STRATEGIES:
        raise UnknownName("strategy", name, NAMES)
    return _STRATEGIES[name]()


__all__ = ["NAMES", "Status", "Strategy", "get"]
