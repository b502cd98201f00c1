"""Multi-turn angle from an encoder that measures the angle within one turn."""

from __future__ import annotations

from typing import final

ARRIVAL_SPREAD = 0.005
"""Most by which the spacing of two arrivals is shorter than that of their measurements (ours) [s]."""


@final
class TurnCount:
    """Unwrapped position of one encoder, in its steps, starting at 0 with the first reading.

    Each reading moves the position by the shortest way:
    ``d = (raw - previous + modulus / 2) mod modulus - modulus / 2``, so ``-modulus / 2 <= d < modulus / 2``.
    That is right while less than half a turn passes between two readings. The count is therefore lost, and stays so
    until `restart`, after a silence in which the motor can turn half a turn, and after a step that its largest speed
    does not explain (another encoder answered, or the motor lost its supply).
    """

    __slots__ = ("_half", "_modulus", "_previous", "_silence_max", "_speed_max", "_time", "is_lost", "steps")

    def __init__(self, modulus: int, silence_max: float) -> None:
        """Count turns of an encoder.

        Args:
            modulus: steps of one turn, even (8192 of a GM6020, 4096 of a Feetech STS).
            silence_max: time of half a turn at the motor's largest speed, see `MotorDataSheet.silence_max` [s].
        """
        self._modulus = modulus
        self._half = modulus // 2
        self._silence_max = silence_max
        self._speed_max = self._half / silence_max
        self._previous: int | None = None
        self._time = 0.0
        self.steps = 0
        """Position since the first reading [steps]."""
        self.is_lost = False
        """Whether a turn may have been missed since the start or the last `restart`."""

    def update(self, raw: int, time: float) -> int:
        """Add a reading, from 0 to ``modulus - 1``, that arrived at ``time`` [s]; the position [steps]."""
        previous = self._previous
        if previous is not None:
            change = (raw - previous + self._half) % self._modulus - self._half
            passed = time - self._time
            self.steps += change
            if passed > self._silence_max or abs(change) > self._speed_max * (passed + ARRIVAL_SPREAD):
                self.is_lost = True
        self._previous = raw
        self._time = time
        return self.steps

    def restart(self) -> None:
        """Trust the count from here on; the position goes on from its present value, without a jump."""
        self.is_lost = False
