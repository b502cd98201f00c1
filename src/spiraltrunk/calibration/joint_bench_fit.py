"""Stiffness and damping of single joints from a bench: static loads, and ring-downs."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import least_squares, nnls
from scipy.stats import t as student

from spiraltrunk.checks import read_numbers
from spiraltrunk.design.rules import GRAVITY
from spiraltrunk.errors import ModelError

_ONSET = math.radians(2.0)
"""Bend over which the onset moment is built up [rad] (ours)."""

_CONTACTS = np.radians(np.arange(10.0, 29.6, 0.5))
"""Contact angles that are tried [rad]."""

_CLEAR = 5.0
"""Least amplitude of a ring-down over the RMS of its residuals [-] (ours)."""

_LEAST_MOMENT = 1e-9
"""Least moment at the largest load [N m] (ours: below it no bench measures, and the least squares round to zero)."""

_MOST_SAMPLES = 100_000


@final
@dataclass(frozen=True, kw_only=True)
class Interval:
    """A fitted number and its 95 % confidence interval."""

    value: float
    """The number."""
    low: float
    """Lower end."""
    high: float
    """Upper end."""


_ZERO = Interval(value=0.0, low=0.0, high=0.0)


@final
@dataclass(frozen=True, kw_only=True)
class StaticFit:
    """A joint under static loads."""

    beam: Interval
    """Stiffness by the beam law alone [N m/rad]."""
    stiffness: Interval
    """Stiffness K of the selected law [N m/rad]."""
    onset: Interval
    """Onset moment M_0 [N m]; 0 where the law has none."""
    faces: Interval
    """Contact stiffness K_f of the faces [N m/rad]; 0 where the law has none."""
    faces_from: Interval
    """Contact angle q_f, not a number where the law has none [rad]."""
    beam_error: float
    """Root mean square of the residuals of the beam law [N m]."""
    error: float
    """Root mean square of the residuals of the selected law [N m]."""

    @property
    def is_beam(self) -> bool:
        """Whether the beam law alone was selected."""
        return self.onset.value == 0.0 and self.faces.value == 0.0

    def moment(self, bend: ArrayLike) -> np.ndarray:
        """Moment of the selected law at bends [rad], their shape [N m]."""
        q = np.asarray(bend, float)
        contact = 0.0 if self.faces.value == 0.0 else self.faces.value * np.maximum(0.0, q - self.faces_from.value)
        return np.asarray(self.stiffness.value * q + self.onset.value * (1 - np.exp(-q / _ONSET)) + contact)


@final
@dataclass(frozen=True, kw_only=True)
class RingFit:
    """A ring-down of a joint."""

    frequency: Interval
    """Damped frequency w_d / 2 pi [Hz]."""
    damping_ratio: Interval
    """Damping ratio zeta [-]."""
    stiffness: Interval
    """Stiffness K, with the uncertainty of the inertia [N m/rad]."""
    damping: Interval
    """Damping, likewise [N m s/rad]."""
    error: float
    """Root mean square of the residuals, in the unit of the record."""
    law: np.ndarray
    """Amplitude of the cosine, w_d, zeta, amplitude of the sine and offset, shape (5,)."""

    def signal(self, time: ArrayLike) -> np.ndarray:
        """Fitted signal at times since the record's first [s], their shape."""
        return _ring_down(self.law, np.asarray(time, float))


def fit_static(bend: ArrayLike, mass: ArrayLike, lever_arm: ArrayLike) -> StaticFit:
    """Stiffness of one joint under static loads, by least squares without negative terms.

    The moment is M = m g l, with the scale's reading m and the lever arm l square to the joint. To the beam law M = K q
    two terms are added where they lower the Bayesian information criterion,

        M = K q + M_0 (1 - exp(-q / 2 deg)) + K_f max(0, q - q_f),

    an onset moment M_0, as of dry friction in the print or of creep between readings, and contact of the faces from the
    angle q_f on. Intervals take in all contact angles that fit no worse than chance has it.

    Args:
        bend: deflections, shape (n,) [rad].
        mass: scale readings, shape (n,) [kg].
        lever_arm: distance from the joint at which the scale pushes, shape (n,) or one number [m].

    Raises:
        ModelError: for numbers that are not finite or negative, or fewer than three readings of a deflected joint.
    """
    q, moment = _read_loads(bend, mass, lever_arm)
    inside = _CONTACTS[(q[q > 0].min() < _CONTACTS) & (q.max() > _CONTACTS)].tolist()
    forms = [(("beam",), math.nan), (("beam", "onset"), math.nan)]
    forms += [(names, at) for at in inside for names in (("beam", "faces"), ("beam", "onset", "faces"))]
    beam, *laws = [law for names, at in forms if (law := _fit_law(q, moment, names, at)) is not None]
    best = min([beam, *laws], key=_read_bic)
    step = float(_CONTACTS[1] - _CONTACTS[0])
    if "faces" in best.names:
        between = (best.contact + np.linspace(-1, 1, 41)[1:-1] * step).tolist()
        laws += [law for at in between if (law := _fit_law(q, moment, best.names, at)) is not None]
        best = min((law for law in laws if law.names == best.names), key=_read_bic)
    worse = 1 + float(student.ppf(0.975, best.freedom)) ** 2 / best.freedom
    alike = [best, *(law for law in laws if law.names == best.names and law.error**2 <= worse * best.error**2)]
    starts = [law.contact for law in alike]
    return StaticFit(
        beam=beam.interval("beam"), stiffness=_union_interval(alike, "beam"), onset=_union_interval(alike, "onset"),
        faces=_union_interval(alike, "faces"),
        faces_from=Interval(value=best.contact, low=min(starts) - step / 40, high=max(starts) + step / 40),
        beam_error=beam.error, error=best.error,
    )  # fmt: skip


def fit_ring_down(time: ArrayLike, acceleration: ArrayLike, inertia: float, inertia_spread: float = 0.0) -> RingFit:
    """Stiffness and damping of one joint from a ring-down, by least squares.

        a(t) = A exp(-zeta w t) cos(w_d t + p) + c,   w_d = w sqrt(1 - zeta^2),   K = I w^2,   damping = 2 zeta w I.

    Args:
        time: shape (n,), increasing [s].
        acceleration: any signal in proportion to the swing, shape (n,).
        inertia: I of all that swings, about the joint [kg m^2].
        inertia_spread: standard deviation of that [kg m^2].

    Raises:
        ModelError: for fewer than 16 samples, numbers that are not finite, or no decaying oscillation.
    """
    t, a = _read_record(time, acceleration)
    if not (math.isfinite(inertia) and inertia > 0 and math.isfinite(inertia_spread) and inertia_spread >= 0):
        allowed = "finite, above 0 kg m^2, with a standard deviation of 0 or more"
        raise ModelError(f"inertia is {inertia!r} with a standard deviation of {inertia_spread!r}; allowed: {allowed}")
    begin = _guess_ring_down(t, a)
    found = least_squares(lambda p: _ring_down(p, t) - a, begin, x_scale=np.maximum(np.abs(begin), 1e-3), max_nfev=300)
    cosine, omega, ratio, sine, _ = found.x.tolist()
    omega, freedom = abs(omega), len(t) - len(begin)
    error = math.sqrt(2 * found.cost / freedom)
    if not 0.0 < ratio < 0.99 or not found.success:
        raise ModelError(f"the record has no decaying oscillation (damping ratio {ratio:.3g}); allowed: a ring-down")
    if not math.hypot(cosine, sine) > _CLEAR * error:
        raise ModelError(
            f"the record has no oscillation above its noise (amplitude {math.hypot(cosine, sine):.3g}, {error:.3g} "
            "left); allowed: a ring-down that begins with the first sample"
        )
    covariance = error**2 * np.linalg.pinv(found.jac.T @ found.jac)
    by_omega, by_ratio = math.sqrt(covariance[1, 1]) / omega, math.sqrt(covariance[2, 2])
    by_inertia = inertia_spread / inertia
    natural = omega / math.sqrt(1 - ratio**2)
    stiffness, damping = inertia * natural**2, 2 * ratio * natural * inertia
    return RingFit(
        frequency=_interval(omega / (2 * math.pi), by_omega * omega / (2 * math.pi), freedom),
        damping_ratio=_interval(ratio, by_ratio, freedom),
        stiffness=_interval(stiffness, stiffness * math.hypot(2 * by_omega, by_inertia), freedom),
        damping=_interval(damping, damping * math.hypot(by_ratio / ratio, by_omega, by_inertia), freedom),
        error=error, law=found.x.copy(),
    )  # fmt: skip


@final
@dataclass(frozen=True, kw_only=True)
class _Law:
    """A law with some of the terms, fitted."""

    names: tuple[str, ...]
    factors: np.ndarray
    deviation: np.ndarray
    contact: float
    error: float
    bic: float
    freedom: int

    def interval(self, name: str) -> Interval:
        place = self.names.index(name)
        return _interval(float(self.factors[place]), float(self.deviation[place]), self.freedom)


def _read_bic(law: _Law) -> float:
    return law.bic


def _fit_law(q: np.ndarray, moment: np.ndarray, names: tuple[str, ...], contact: float) -> _Law | None:
    """Non-negative least squares; None where there are too few readings or a term vanishes."""
    terms = {"beam": q, "onset": 1 - np.exp(-q / _ONSET), "faces": np.maximum(0.0, q - contact)}
    columns = np.column_stack([terms[name] for name in names])
    size, count = len(moment), len(names) + ("faces" in names)
    if size <= count + 1:
        return None
    factors, rest = nnls(columns, moment)
    if (factors <= 0).any():
        return None
    variance = rest**2 / (size - len(names))
    return _Law(
        names=names, factors=factors, contact=contact, error=rest / math.sqrt(size), freedom=size - count,
        deviation=np.sqrt(variance * np.diag(np.linalg.pinv(columns.T @ columns))),
        bic=size * math.log(max(rest**2 / size, 1e-16)) + count * math.log(size),
    )  # fmt: skip


def _union_interval(laws: list[_Law], name: str) -> Interval:
    """Coefficient of the first law, with the union of its intervals over all laws; 0 where the term is absent."""
    if name not in laws[0].names:
        return _ZERO
    each = [law.interval(name) for law in laws]
    return Interval(value=each[0].value, low=min(one.low for one in each), high=max(one.high for one in each))


def _interval(value: float, deviation: float, freedom: int) -> Interval:
    reach = float(student.ppf(0.975, freedom)) * deviation
    return Interval(value=value, low=value - reach, high=value + reach)


def _read_loads(bend: ArrayLike, mass: ArrayLike, lever_arm: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
    """Bends [rad] and moments [N m]."""
    parts = (read_numbers("bend", bend), read_numbers("mass", mass), read_numbers("lever_arm", lever_arm))
    try:
        q, m, arm = np.broadcast_arrays(*parts)
    except ValueError:
        raise ModelError("bend, mass and lever_arm do not fit; allowed: numbers, one each a reading") from None
    if q.ndim != 1 or min(part.min(initial=0.0) for part in (q, m, arm)) < 0:
        raise ModelError("bend, mass or lever_arm is negative, or no row; allowed: rows of numbers, 0 or more")
    moment = GRAVITY * m * arm
    count = int(((q > 0) & (moment > 0)).sum())
    if count < 3:
        raise ModelError(f"{count} readings of a joint that is deflected by a moment; allowed: three or more")
    if moment.max() < _LEAST_MOMENT:
        allowed = f"at least {_LEAST_MOMENT:g} N m at the largest load"
        raise ModelError(f"the moments reach {moment.max():.3g} N m; allowed: {allowed}")
    return q.copy(), moment


def _read_record(time: ArrayLike, acceleration: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
    """Times from the first on [s], and the signal."""
    t, a = read_numbers("time", time), read_numbers("acceleration", acceleration)
    if t.ndim != 1 or t.shape != a.shape or not 16 <= len(t) <= _MOST_SAMPLES:
        raise ModelError(
            f"time and acceleration have shapes {t.shape}, {a.shape}; allowed: equal, 16 to {_MOST_SAMPLES} samples"
        )
    if not (np.diff(t) > 0).all():
        raise ModelError("time does not increase; allowed: increasing times")
    if not np.ptp(a) > 0:
        raise ModelError("every sample is the same; allowed: a ring-down")
    return t - t[0], a


def _ring_down(law: np.ndarray, t: np.ndarray) -> np.ndarray:
    """The law of `RingFit` at times ``t`` [s]."""
    cosine, omega, ratio, sine, offset = law
    decay = np.exp(-ratio * abs(omega) / math.sqrt(max(1 - ratio**2, 1e-6)) * t)
    return np.asarray(decay * (cosine * np.cos(omega * t) + sine * np.sin(omega * t)) + offset)


def _guess_ring_down(t: np.ndarray, a: np.ndarray) -> np.ndarray:
    """First guess of the law: strongest frequency, and the logarithmic decrement of the first two periods."""
    even = np.linspace(t[0], t[-1], len(t))
    swing = np.interp(even, t, a - a.mean())
    power = np.abs(np.fft.rfft(swing, 8 * len(t)))
    omega = 2 * math.pi * (int(power[8:].argmax()) + 8) / (8 * len(t) * (even[1] - even[0]))
    period = max(4, int(2 * math.pi / omega / (even[1] - even[0])))
    first, second = np.abs(swing[:period]).max(), np.abs(swing[period : 2 * period]).max(initial=0.0)
    ratio = float(np.clip(math.log(max(first / max(second, 1e-12), 1.01)) / (2 * math.pi), 0.005, 0.6))
    return np.array([swing[0], omega, ratio, 0.0, float(a.mean())])
