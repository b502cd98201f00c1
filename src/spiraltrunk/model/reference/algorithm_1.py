"""Compiled: Algorithm 1, the distribution of a pulled cable over the gaps, and the planar bends that follow."""

from __future__ import annotations

import math

import numpy as np

from spiraltrunk.model.reference.constants import Table, compiled


@compiled
def rest_gap(t: Table, sag: np.ndarray, gap: np.ndarray) -> None:
    """Dorsal gaps at rest, the paper's L' = 2 R_hole sin((limit + sag) / 2) [m]."""
    for i in range(gap.size):
        gap[i] = t.diameter[i] * math.sin(0.5 * (t.limit + sag[i]))


@compiled
def shorten(pull: float, t: Table, gap: np.ndarray) -> float:
    """Shorten the dorsal gaps by ``pull`` [m] in total, tip first (paper, Algorithm 1); returns the unused pull [m].

    A gap takes its portion; the excess over its length is shared by the joints nearer to the base in proportion to
    theirs. The excess of joint 1 goes to the joints that are still open, which the paper does not specify.
    """
    level, left = pull, 0.0
    for i in range(gap.size - 1, -1, -1):
        over = level * t.portion[i] - gap[i]
        gap[i] = max(-over, 0.0)
        level += max(over, 0.0) * t.below[i]
        left = max(over, 0.0)
    while left > 0.0:
        level = 0.0
        for i in range(gap.size):
            level += t.portion[i] if gap[i] > 0.0 else 0.0
        if level == 0.0:
            break
        level, left = left / level, 0.0
        for i in range(gap.size):
            if gap[i] > 0.0:
                over = level * t.portion[i] - gap[i]
                gap[i] = max(-over, 0.0)
                left += max(over, 0.0)
    return left


@compiled
def lengthen(pull: float, t: Table, gap: np.ndarray) -> float:
    """Lengthen the dorsal gaps by ``pull`` [m] in total, tip first (paper, Algorithm 1); returns the unused pull [m].

    The mirror of `shorten`, up to the gap at the ventral limit. With ``as_authors`` the excess is measured from the
    straight gap and not from the gap at rest, as in the authors' code.
    """
    if not t.as_authors:
        for i in range(gap.size):
            gap[i] = t.wide[i] - gap[i]
        left = shorten(pull, t, gap)
        for i in range(gap.size):
            gap[i] = t.wide[i] - gap[i]
        return left
    level, before, after, is_open = pull, 0.0, 0.0, False
    for i in range(gap.size - 1, -1, -1):
        share = level * t.portion[i]
        before += gap[i]
        if gap[i] + share > t.wide[i]:
            gap[i] = t.wide[i]
            level += (share - (t.wide[i] - t.straight[i])) * t.below[i]
        else:
            gap[i] = max(gap[i] + share, 0.0)
            is_open = True
        after += gap[i]
    return 0.0 if is_open else max(pull - (after - before), 0.0)


@compiled
def arcsine(x: float) -> float:
    """Angle whose sine is ``x`` in [0, 1] [rad]: the rational approximation of fdlibm, free of branches."""
    is_large = x > 0.5
    z = 0.5 * (1.0 - x) if is_large else x * x
    s = math.sqrt(z) if is_large else x
    angle = s + s * _excess(z)
    return 0.5 * math.pi - 2.0 * angle if is_large else angle


@compiled
def arcsine_narrow(x: float) -> float:
    """`arcsine` for ``x`` up to 0.5, the same to the bit, without the root."""
    return x + x * _excess(x * x)


@compiled
def _excess(z: float) -> float:
    """fdlibm's rational approximation of asin(s) / s - 1, with s the root of ``z``."""
    p = 7.91534994289814532176e-04 + z * 3.47933107596021167570e-05
    p = 2.01212532134862925881e-01 + z * (-4.00555345006794114027e-02 + z * p)
    p = z * (1.66666666666666657415e-01 + z * (-3.25565818622400915405e-01 + z * p))
    q = -6.88283971605453293030e-01 + z * 7.70381505559019352791e-02
    q = 1.0 + z * (-2.40339491173441421878e00 + z * (2.02094576023350569471e00 + z * q))
    return p / q


@compiled
def bend_joint(x: float, half: float, limit: float, cos: float, sin: float) -> tuple[float, float, float]:
    """Bend limit - 2 asin(x) of a joint whose gap is ``x`` diameters, at most the limit ventrally, its cos and sin.

    ``half`` is asin(x); ``cos`` and ``sin`` are those of the limit.
    """
    is_wide = x >= sin
    y = math.sqrt(1.0 - x * x)
    open_cos, open_sin = 1.0 - 2.0 * x * x, 2.0 * x * y
    c, s = cos * open_cos + sin * open_sin, sin * open_cos - cos * open_sin
    return (-limit if is_wide else limit - 2.0 * half), (cos if is_wide else c), (-sin if is_wide else s)


@compiled
def bend_joints(t: Table, gap: np.ndarray, bend: np.ndarray, cos: np.ndarray, sin: np.ndarray) -> None:
    """Bends at the dorsal gaps ``gap``, dorsal positive [rad], with their cos and sin."""
    limit_cos, limit_sin = math.cos(t.limit), math.sin(t.limit)
    for i in range(gap.size):
        x = gap[i] * (1.0 / t.diameter[i])
        bend[i], cos[i], sin[i] = bend_joint(x, arcsine(x), t.limit, limit_cos, limit_sin)
