"""Stiffness and damping of single joints from a bench: static loads, and ring-downs.

A static load is a moment M = m g l (scale reading m, lever arm l square to the joint) at a deflection q. The beam law
of the design is M = K q. Two terms beside it say where a print departs from it:

    M = K q + M_0 (1 - exp(-q / 2 deg)) + K_f max(0, q - q_f),

a moment M_0 that is there from the first degrees on, as of dry friction in the print or of creep between readings, and
faces that meet from q_f on. Terms are taken in only where they lower Schwarz's criterion (BIC). A ring-down is

    a(t) = A exp(-z w t) cos(w_d t + p) + c,   w_d = w sqrt(1 - z^2),   K = I w^2,   damping = 2 z w I,

with I the inertia of all that swings about the joint.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import least_squares, nnls
from scipy.stats import t as student

from spiraltrunk.design.rules import GRAVITY
from spiraltrunk.errors import ModelError

_ONSET = math.radians(2.0)
_FACES = np.radians(np.arange(10.0, 29.6, 0.5))
"""Bends at which faces are tried to meet [rad]."""

_CLEAR = 5.0
"""Amplitude over what the law leaves from which a swing is told from noise [-] (ours)."""

_MOST = 100_000


@final
@dataclass(frozen=True, kw_only=True)
class Interval:
    """A fitted number and its 95 % interval."""

    value: float
    """The number."""
    low: float
    """Lower end."""
    high: float
    """Upper end."""


@final
@dataclass(frozen=True, kw_only=True)
class StaticFit:
    """A joint under static loads."""

    beam: Interval
    """Stiffness by the beam law alone, through the origin [N m/rad]."""
    stiffness: Interval
    """Stiffness K with the terms that the data ask for [N m/rad]."""
    onset: Interval
    """Moment M_0 [N m]; 0 where the data do not ask for it."""
    faces: Interval
    """Stiffness K_f that the faces add [N m/rad]; 0 where the data do not ask for it."""
    faces_from: Interval
    """Bend q_f from which they do, not a number where they do not [rad]."""
    beam_error: float
    """Root mean square of the moments left by the beam law [N m]."""
    error: float
    """The same with the terms [N m]."""
    secant: np.ndarray
    """M / q of each reading but those at rest: level where the beam law holds, shape (n,) [N m/rad]."""

    @property
    def is_beam(self) -> bool:
        """Whether the beam law alone is enough."""
        return self.onset.value == 0.0 and self.faces.value == 0.0

    def moment(self, bend: ArrayLike) -> np.ndarray:
        """The law's moment at bends [rad], their shape [N m]."""
        q = np.asarray(bend, float)
        start = self.faces_from.value
        beyond = 0.0 if math.isnan(start) else self.faces.value * np.maximum(0.0, q - start)
        return np.asarray(self.stiffness.value * q + self.onset.value * (1 - np.exp(-q / _ONSET)) + beyond)


@final
@dataclass(frozen=True, kw_only=True)
class RingFit:
    """A joint that rings down."""

    frequency: Interval
    """Damped frequency w_d / 2 pi [Hz]."""
    damping_ratio: Interval
    """z [-]."""
    stiffness: Interval
    """K, with the inertia's own uncertainty [N m/rad]."""
    damping: Interval
    """Damping [N m s/rad]."""
    error: float
    """Root mean square of what the law leaves, in the unit of the record."""
    law: np.ndarray
    """Its cosine, w_d, z, sine and level, time from the record's first, shape (5,)."""

    def signal(self, time: ArrayLike) -> np.ndarray:
        """The law's signal at times since the record's first [s], their shape."""
        return _ring(self.law, np.asarray(time, float))


def fit_static(bend: ArrayLike, mass: ArrayLike, lever_arm: ArrayLike) -> StaticFit:
    """Stiffness of one joint under static loads.

    Args:
        bend: deflections, shape (n,) [rad].
        mass: scale readings, shape (n,) [kg].
        lever_arm: distance from the joint at which the scale pushes, shape (n,) or one number [m].

    Raises:
        ModelError: for numbers that are not finite or negative, or fewer than three readings of a deflected joint.
    """
    q, moment = _read_loads(bend, mass, lever_arm)
    ones = np.column_stack([q])
    beam = float(q @ moment / (q @ q))
    best = _solve_terms(ones, moment, None)
    laws = [law for columns, at in _propose(q) if (law := _solve_terms(columns, moment, at)) is not None]
    best, laws = _refine(min([*([] if best is None else [best]), *laws], key=_score_of), laws, (q, moment))
    pulled, kept = q > 0, _find_alike(best, laws)
    return StaticFit(
        beam=_interval(beam, float(_deviation(ones, moment, np.array([beam]))[0]), len(q) - 1),
        stiffness=_span(best, kept, "beam"), onset=_span(best, kept, "onset"), faces=_span(best, kept, "faces"),
        faces_from=_span_start(best, kept),
        beam_error=float(np.sqrt(np.mean((moment - beam * q) ** 2))), error=best.error,
        secant=moment[pulled] / q[pulled],
    )  # fmt: skip


def fit_ring_down(time: ArrayLike, acceleration: ArrayLike, inertia: float, inertia_spread: float = 0.0) -> RingFit:
    """Stiffness and damping of one joint from a ring-down.

    Args:
        time: shape (n,), increasing [s].
        acceleration: any signal in proportion to the swing, shape (n,).
        inertia: of all that swings, about the joint [kg m^2].
        inertia_spread: standard deviation of that [kg m^2].

    Raises:
        ModelError: for fewer than 16 samples, numbers that are not finite, or no decaying oscillation.
    """
    t, a = _read_record(time, acceleration)
    if not (math.isfinite(inertia) and inertia > 0 and math.isfinite(inertia_spread) and inertia_spread >= 0):
        raise ModelError(f"inertia is {inertia!r} +- {inertia_spread!r}; allowed: finite, above 0 kg m^2")
    begin = _guess_ring(t, a)
    found = least_squares(lambda p: _ring(p, t) - a, begin, x_scale=np.maximum(np.abs(begin), 1e-3), max_nfev=300)
    omega, ratio = abs(float(found.x[1])), float(found.x[2])
    if not 0.0 < ratio < 0.99 or not found.success:
        raise ModelError(f"the record has no decaying oscillation (damping ratio {ratio:.3g}); allowed: a ring-down")
    free = len(t) - len(begin)
    error = float(np.sqrt(2 * found.cost / free))
    swing = math.hypot(found.x[0], found.x[3])
    if not swing > _CLEAR * error:
        raise ModelError(
            f"the record has no oscillation above its noise (amplitude {swing:.3g}, {error:.3g} left); "
            "allowed: a ring-down that begins with the first sample"
        )
    covariance = error**2 * np.linalg.pinv(found.jac.T @ found.jac)
    by_omega, by_ratio = math.sqrt(covariance[1, 1]) / omega, math.sqrt(covariance[2, 2])
    natural = omega / math.sqrt(1 - ratio**2)
    stiffness, damping = inertia * natural**2, 2 * ratio * natural * inertia
    share = inertia_spread / inertia
    return RingFit(
        frequency=_interval(omega / (2 * math.pi), by_omega * omega / (2 * math.pi), free),
        damping_ratio=_interval(ratio, by_ratio, free),
        stiffness=_interval(stiffness, stiffness * math.hypot(2 * by_omega, share), free),
        damping=_interval(damping, damping * math.hypot(by_ratio / ratio, by_omega, share), free),
        error=error, law=found.x.copy(),
    )  # fmt: skip


@final
@dataclass(frozen=True, kw_only=True)
class _Terms:
    """A law with some of the terms."""

    factors: np.ndarray
    deviation: np.ndarray
    names: tuple[str, ...]
    at: float
    error: float
    score: float
    free: int

    def interval(self, name: str) -> Interval:
        place = self.names.index(name)
        return _interval(float(self.factors[place]), float(self.deviation[place]), self.free)


def _score_of(law: _Terms) -> float:
    return law.score


def _refine(best: _Terms, laws: list[_Terms], readings: tuple[np.ndarray, np.ndarray]) -> tuple[_Terms, list[_Terms]]:
    """The best law and all of its kind, faces tried to meet at bends between those that were tried."""
    if math.isnan(best.at):
        return best, laws
    (q, moment), names = readings, best.names
    onset = [1 - np.exp(-q / _ONSET)] if "onset" in names else []
    between = best.at + np.linspace(-1, 1, 41)[1:-1] * float(_FACES[1] - _FACES[0])
    tried = [_solve_terms(np.column_stack([q, *onset, np.maximum(0.0, q - at)]), moment, at) for at in between.tolist()]
    alike = [law for law in (*laws, *tried) if law is not None and law.names == names]
    return min(alike, key=_score_of), alike


def _find_alike(best: _Terms, laws: list[_Terms]) -> list[_Terms]:
    """The best law, and the same with faces that meet elsewhere where it fits no worse than chance has it (95 %)."""
    worse = 1 + float(student.ppf(0.975, max(best.free, 1))) ** 2 / max(best.free, 1)
    return [best, *(law for law in laws if law.names == best.names and law.error**2 <= worse * best.error**2)]


def _span(best: _Terms, kept: list[_Terms], name: str) -> Interval:
    """A factor with the ends of its intervals by all laws that are kept; 0 where the law has no such term."""
    if name not in best.names:
        return Interval(value=0.0, low=0.0, high=0.0)
    each = [law.interval(name) for law in kept]
    return Interval(value=each[0].value, low=min(one.low for one in each), high=max(one.high for one in each))


def _span_start(best: _Terms, kept: list[_Terms]) -> Interval:
    """Bend from which the faces meet, to half a step of those that are tried last [rad]."""
    starts, half = [law.at for law in kept], float(_FACES[1] - _FACES[0]) / 40
    return Interval(value=best.at, low=min(starts) - half, high=max(starts) + half)


def _propose(q: np.ndarray) -> list[tuple[np.ndarray, float | None]]:
    """Columns of every law with more than the beam, and where its faces meet."""
    onset = 1 - np.exp(-q / _ONSET)
    laws: list[tuple[np.ndarray, float | None]] = [(np.column_stack([q, onset]), None)]
    for at in _FACES[(q[q > 0].min() < _FACES) & (q.max() > _FACES)]:
        faces = np.maximum(0.0, q - at)
        laws += [(np.column_stack([q, faces]), float(at)), (np.column_stack([q, onset, faces]), float(at))]
    return laws


def _solve_terms(columns: np.ndarray, moment: np.ndarray, at: float | None) -> _Terms | None:
    """Least squares with no negative term; None where there are too few readings or a term vanishes."""
    count = columns.shape[1] + (at is not None)
    if len(moment) <= count + 1:
        return None
    factors, rest = nnls(columns, moment)
    if (factors <= 0).any():
        return None
    size = len(moment)
    score = size * math.log(max(rest**2 / size, 1e-16)) + count * math.log(size)
    names = ("beam", *(["onset"] if columns.shape[1] - (at is not None) == 2 else []), *(["faces"] if at else []))
    return _Terms(
        factors=factors, deviation=_deviation(columns, moment, factors), names=names, at=math.nan if at is None else at,
        error=float(rest / math.sqrt(size)), score=score, free=size - count,
    )  # fmt: skip


def _deviation(columns: np.ndarray, moment: np.ndarray, factors: np.ndarray) -> np.ndarray:
    """Standard deviations of least squares, shape of the factors."""
    left = moment - columns @ factors
    variance = float(left @ left) / max(len(moment) - len(factors), 1)
    return np.asarray(np.sqrt(variance * np.diag(np.linalg.pinv(columns.T @ columns))))


def _interval(value: float, deviation: float, free: int) -> Interval:
    reach = float(student.ppf(0.975, max(free, 1))) * deviation
    return Interval(value=value, low=value - reach, high=value + reach)


def _read_loads(bend: ArrayLike, mass: ArrayLike, lever_arm: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
    try:
        q, m, arm = np.broadcast_arrays(*(np.asarray(part, float) for part in (bend, mass, lever_arm)))
    except (TypeError, ValueError):
        raise ModelError("bend, mass and lever_arm do not fit; allowed: numbers, one each a reading") from None
    if q.ndim != 1 or not all(np.isfinite(part).all() and (part >= 0).all() for part in (q, m, arm)):
        raise ModelError(
            "bend, mass or lever_arm is negative or not finite; allowed: rows of finite numbers, 0 or more"
        )
    count = int(((q > 0) & (m > 0) & (arm > 0)).sum())
    if count < 3:
        raise ModelError(f"{count} readings of a joint that is deflected by a moment; allowed: three or more")
    return q.copy(), GRAVITY * m * arm


def _read_record(time: ArrayLike, acceleration: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
    try:
        t, a = np.asarray(time, float), np.asarray(acceleration, float)
    except (TypeError, ValueError):
        raise ModelError("time or acceleration holds what is no number; allowed: finite numbers") from None
    if t.ndim != 1 or t.shape != a.shape or not 16 <= len(t) <= _MOST:
        raise ModelError(
            f"time and acceleration have shapes {t.shape}, {a.shape}; allowed: equal, 16 to {_MOST} samples"
        )
    if not (np.isfinite(t).all() and np.isfinite(a).all() and (np.diff(t) > 0).all()):
        raise ModelError("time does not increase, or a number is not finite; allowed: increasing times, finite numbers")
    if not np.ptp(a) > 0:
        raise ModelError("every sample is the same; allowed: a ring-down")
    return t - t[0], a


def _ring(p: np.ndarray, t: np.ndarray) -> np.ndarray:
    """Amplitudes of cosine and sine, damped angular frequency, damping ratio, level."""
    cosine, omega, ratio, sine, level = p
    decay = np.exp(-ratio * abs(omega) / math.sqrt(max(1 - ratio**2, 1e-6)) * t)
    return np.asarray(decay * (cosine * np.cos(omega * t) + sine * np.sin(omega * t)) + level)


def _guess_ring(t: np.ndarray, a: np.ndarray) -> np.ndarray:
    """The strongest frequency, and how fast the halves of the record fall."""
    even = np.linspace(t[0], t[-1], len(t))
    swing = np.interp(even, t, a - a.mean())
    power = np.abs(np.fft.rfft(swing, 8 * len(t)))
    omega = 2 * math.pi * max(int(power[8:].argmax()) + 8, 1) / (8 * len(t) * (even[1] - even[0]))
    window = max(4, int(2 * math.pi / omega / (even[1] - even[0])))
    first, second = np.abs(swing[:window]).max(), np.abs(swing[window : 2 * window]).max(initial=0.0)
    ratio = float(np.clip(math.log(max(first / max(second, 1e-12), 1.01)) / (2 * math.pi), 0.005, 0.6))
    return np.array([swing[0], omega, ratio, 0.0, float(a.mean())])
