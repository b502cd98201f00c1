"""Bench records of single joints to figures, a picture and what a calibration may know beforehand."""

from __future__ import annotations

import json
import math
import platform
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any, final

import numpy as np

import spiraltrunk
from spiraltrunk.calibration.joint_bench_csv import StaticLoads, load_ring_down, load_static_loads
from spiraltrunk.calibration.joint_bench_fit import Interval, RingFit, StaticFit, fit_ring_down, fit_static
from spiraltrunk.calibration.parameters import BenchStiffness
from spiraltrunk.design.rules import GRAVITY
from spiraltrunk.errors import ModelError, TakeError
from spiraltrunk.files.atomic import atomic_folder
from spiraltrunk.report.joint_bench_plot import LoadedJoint, RingDown, build_loads_figure
from spiraltrunk.report.style import write_figure

FILES = ("bench.png", "result.json")
"""What bench records alone leave behind."""

TRUST = 0.10
"""Standard deviation of the logarithm of a stiffness from the bench, beside its interval's [-] (ours: levers and angles
to some percent, and the first cycles soften a print)."""

_SURE = 1.959963984540054


@final
@dataclass(frozen=True, kw_only=True)
class RingFile:
    """A ring-down and what swung."""

    joint: int
    """Joint, 1 at the base."""
    path: str
    """The record."""
    inertia: float
    """Of all that swings, about the joint [kg m^2]."""
    inertia_spread: float
    """Standard deviation of that [kg m^2]."""


@final
@dataclass(frozen=True, kw_only=True)
class Ring:
    """One ring-down and its fit."""

    joint: int
    """Joint, 1 at the base."""
    time: np.ndarray
    """Since the first sample, shape (n,) [s]."""
    signal: np.ndarray
    """What was recorded, shape (n,)."""
    fit: RingFit
    """Its law."""


@final
@dataclass(frozen=True, kw_only=True)
class Bench:
    """All records of a bench, fitted."""

    static: tuple[tuple[StaticLoads, StaticFit], ...]
    """Static loads by joint."""
    rings: tuple[Ring, ...]
    """Ring-downs."""


def fit_bench(loads: str | None, rings: Sequence[RingFile]) -> Bench:
    """Read and fit.

    Args:
        loads: file of static loads, if there is one.
        rings: ring-downs.

    Raises:
        TakeError: for records that cannot be read or fitted.
    """
    static = []
    for joint in () if loads is None else load_static_loads(loads):
        try:
            static.append((joint, fit_static(joint.bend, joint.mass, joint.lever_arm)))
        except ModelError as error:
            raise TakeError(f"joint {joint.joint}: {error}", file=str(loads)) from None
    return Bench(static=tuple(static), rings=tuple(_fit_ring(ring) for ring in rings))


def _fit_ring(ring: RingFile) -> Ring:
    time, signal = load_ring_down(ring.path)
    try:
        fit = fit_ring_down(time, signal, ring.inertia, ring.inertia_spread)
    except ModelError as error:
        raise TakeError(f"joint {ring.joint}: {error}", file=ring.path) from None
    return Ring(joint=ring.joint, time=time - time[0], signal=signal, fit=fit)


def read_stiffness(bench: Bench) -> tuple[BenchStiffness, ...]:
    """What a calibration may know of the joints beforehand: static stiffness between the first degrees and the faces.

    Ring-downs are left out: a print is stiffer when it swings than when it is held, and shapes are held.
    """
    return tuple(
        BenchStiffness(joint=loads.joint, value=fit.stiffness.value, spread=_spread_of(fit.stiffness))
        for loads, fit in bench.static
    )


def _spread_of(interval: Interval) -> float:
    return min(math.hypot(TRUST, (interval.high - interval.low) / (2 * _SURE * interval.value)), 100.0)


def compute_bench_result(bench: Bench) -> dict[str, Any]:
    """Everything in plain values, ready for JSON; SI but where a key wears its unit."""
    return {
        **tell_bench(bench),
        "versions": {
            "spiraltrunk": spiraltrunk.__version__, "python": platform.python_version(), "numpy": version("numpy"),
        },
        "files": [],
    }  # fmt: skip


def tell_bench(bench: Bench) -> dict[str, Any]:
    """Fits of all records in plain values."""
    return {
        "static": [_tell_static(loads, fit) for loads, fit in bench.static],
        "ring_down": [_tell_ring(ring) for ring in bench.rings],
    }


def write_bench_folder(bench: Bench, result: dict[str, Any], folder: str | Path) -> dict[str, Any]:
    """Write picture and figures; the result with its files.

    Raises:
        OSError: where the folder cannot be written.
    """
    told = {**result, "files": list(FILES)}
    with atomic_folder(folder, FILES) as draft:
        write_bench_plot(bench, draft / "bench.png")
        (draft / "result.json").write_text(json.dumps(told, indent=2, allow_nan=False) + "\n")
    return told


def write_bench_plot(bench: Bench, path: Path) -> Path:
    """Readings and laws of all records, in one picture.

    Raises:
        OSError: where the file cannot be written.
    """
    loaded: list[LoadedJoint | RingDown] = [
        LoadedJoint(
            name=f"Joint {loads.joint}", bend=loads.bend, moment=GRAVITY * loads.mass * loads.lever_arm,
            beam=fit.beam.value, law=fit.moment, faces_from=fit.faces_from.value,
        )
        for loads, fit in bench.static
    ]  # fmt: skip
    loaded += [
        RingDown(name=f"Joint {ring.joint}, ring-down", time=ring.time, signal=ring.signal, law=ring.fit.signal)
        for ring in bench.rings
    ]
    return write_figure(build_loads_figure(loaded), path)


def _tell_static(loads: StaticLoads, fit: StaticFit) -> dict[str, Any]:
    return {
        "joint": loads.joint, "readings": len(loads.bend), "is_beam": fit.is_beam,
        "beam_law_nm_per_rad": _tell(fit.beam), "stiffness_nm_per_rad": _tell(fit.stiffness),
        "onset_nm": _tell(fit.onset), "faces_nm_per_rad": _tell(fit.faces),
        "faces_from_deg": _tell(fit.faces_from, 180 / math.pi), "beam_law_rms_nm": fit.beam_error,
        "rms_nm": fit.error,
    }  # fmt: skip


def _tell_ring(ring: Ring) -> dict[str, Any]:
    fit = ring.fit
    return {
        "joint": ring.joint, "samples": len(ring.time), "frequency_hz": _tell(fit.frequency),
        "damping_ratio": _tell(fit.damping_ratio), "stiffness_nm_per_rad": _tell(fit.stiffness),
        "damping_nms_per_rad": _tell(fit.damping), "rms": fit.error,
    }  # fmt: skip


def _tell(interval: Interval, factor: float = 1.0) -> dict[str, float | None]:
    parts = {"value": interval.value, "low_95": interval.low, "high_95": interval.high}
    return {name: factor * value if math.isfinite(value) else None for name, value in parts.items()}
