"""Which request an answer belongs to, so that feedback has its true age however late it comes. No I/O.

An answer of a servo has no number, but as many bytes as were asked for: each request asks for another number of them.
"""

from __future__ import annotations

import math
from collections import deque
from typing import Final, NamedTuple, final

from spiraltrunk.hardware.motors.sts import codec

N_SIZE: Final = codec.FEEDBACK_SIZE_MOST - codec.FEEDBACK_SIZE + 1
"""Numbers of bytes that are asked for in turn [-]."""

LATE_MOST: Final = 1.0
"""Time after which no answer to a request is expected any more [s] (ours)."""

QUIET: Final = 0.06
"""Silence after which no answer is expected to be under way, where requests are in doubt [s] (ours): more than any
period of control with these servos."""


@final
class _Request(NamedTuple):
    """A request to all servos."""

    size: int
    """Bytes that it asks for."""
    time: float
    """When it was sent [s]."""
    answered: set[int]
    """Ids of the servos that have answered."""


@final
class RequestTimes:
    """Requests that may still be answered, the oldest first.

    The wire passes requests and answers in their order: once one servo has answered a request, no servo answers those
    before it. So a lost answer ages nothing but the feedback that is missing. Where all servos were silent for more
    than `N_SIZE` requests, an answer may belong to several. Such an answer has no time, and nothing is asked until the
    wire is quiet: late answers go on to come meanwhile, others do not.
    """

    def __init__(self) -> None:
        self._open: deque[_Request] = deque()
        self._size = codec.FEEDBACK_SIZE
        self._heard = -math.inf
        self._is_in_doubt = False
        self.latest = -math.inf
        """Time of the latest request; minus infinity before the first [s]."""

    def find_size(self, now: float) -> int | None:
        """Bytes to ask for at ``now`` [s]; None where nothing must be asked."""
        if self._is_in_doubt:
            if now - self._heard < QUIET:
                return None
            self._open.clear()
            self._is_in_doubt = False
        return self._size

    def add(self, now: float) -> None:
        """Note that the bytes of `find_size` were asked for at ``now`` [s]."""
        while self._open and now - self._open[0].time > LATE_MOST:
            self._open.popleft()
        self._open.append(_Request(self._size, now, set()))
        self._size = codec.FEEDBACK_SIZE + (self._size - codec.FEEDBACK_SIZE + 1) % N_SIZE
        self.latest = now

    def take(self, servo_id: int, size: int, now: float) -> float | None:
        """Time of the request that a servo answers with ``size`` bytes, heard at ``now`` [s].

        None where it was not asked for them, or may answer several requests.
        """
        asked = [one for one in self._open if one.size == size and servo_id not in one.answered]
        if not asked:
            return None
        while self._open[0] is not asked[0]:
            self._open.popleft()
        asked[0].answered.add(servo_id)
        self._is_in_doubt = self._is_in_doubt or len(asked) > 1
        self._heard = now
        return asked[0].time if len(asked) == 1 else None
