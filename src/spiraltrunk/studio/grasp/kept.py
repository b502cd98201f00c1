"""Grasps of pages that were closed, kept for their reload."""

from __future__ import annotations

import threading
from collections import OrderedDict
from dataclasses import dataclass
from typing import Any, final

from spiraltrunk.studio.grasp.request import GraspRequest
from spiraltrunk.workflows.grasp.recording import Recording

MOST_KEPT = 8
"""Grasps that are kept; of more, the oldest is forgotten [-]."""


@final
@dataclass(frozen=True, kw_only=True)
class KeptGrasp:
    """A grasp that ended."""

    name: str
    """Name by which a reload finds it."""
    request: GraspRequest
    """What was asked for."""
    recording: Recording
    """Bodies and frames."""
    result: dict[str, Any]
    """Its result."""


_kept: OrderedDict[str, KeptGrasp] = OrderedDict()
_lock = threading.Lock()


def keep_grasp(grasp: KeptGrasp) -> None:
    """Keep the grasp of a page that closes."""
    with _lock:
        _kept[grasp.name] = grasp
        while len(_kept) > MOST_KEPT:
            _kept.popitem(last=False)


def find_grasp(name: str) -> KeptGrasp | None:
    """Take the grasp that was kept for a reloaded page; None where it is no longer kept."""
    with _lock:
        return _kept.pop(name, None)
