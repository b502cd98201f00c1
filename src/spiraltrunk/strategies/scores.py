"""Scores of assessments: the predicted chance that a first try succeeds, a rate times one factor for each margin."""

from __future__ import annotations

from spiraltrunk.control.strategy import Assessment

AT_LIMIT = 0.5
"""Factor of a margin that is used up [-] (ours), where trials did not tell another."""

RATE = "; rate "
"""What stands between a reason and the rate of success."""


def refuse(reason: str) -> Assessment:
    """The assessment of a task that the strategy cannot do."""
    return Assessment(feasible=False, score=0.0, reason=reason)


def margin_factor(margin: float, ample: float, at_limit: float = AT_LIMIT) -> float:
    """Factor of a margin: ``at_limit`` [-] at 0 or less, linear up to 1 at ``ample``, of the margin's unit [-]."""
    return at_limit + (1 - at_limit) * min(1.0, max(0.0, margin / ample))


def accept(rate: float, factors: dict[str, float], reason: str) -> Assessment:
    """The assessment of a feasible task.

    Args:
        rate: rate of success of first tries where all margins are ample [-].
        factors: factor of each margin, as of `margin_factor`, under what limits it [-].
        reason: what decides, in words and numbers; the rate and the factors below 1 are told after it.
    """
    score, told = rate, "".join(format_factor(name, factor) for name, factor in factors.items())
    for factor in factors.values():
        score *= factor
    return Assessment(feasible=True, score=score, reason=f"{reason}{RATE}{rate:g}{told}")


def format_factor(name: str, factor: float) -> str:
    """A factor of a score as it follows in a reason; empty for one that is 1 to two digits."""
    return "" if round(factor, 2) == 1.0 else f", times {factor:.2f} for {name}"


def tell_apart(length: float, limit: float) -> tuple[str, str, str]:
    """By how much a length passes a limit [m], and both, in millimetres with as many digits as tell them apart."""
    by, own, most = (1e3 * each for each in (abs(length - limit), length, limit))
    digits = next((n for n in range(6) if round(by, n) > 0 and round(own, n) != round(most, n)), 6)
    return f"{by:.{digits}f}", f"{own:.{digits}f}", f"{most:.{digits}f}"


def format_mm(length: float) -> str:
    """A length in millimetres, in centimetres from 10 cm on."""
    return f"{1e2 * length:.0f} cm" if length >= 0.1 else f"{1e3 * length:.0f} mm"
