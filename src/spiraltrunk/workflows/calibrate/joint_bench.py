"""Joint bench records: fits of single joints as figures, a plot, and prior knowledge for a calibration."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, final

import numpy as np

from spiraltrunk.calibration.calibrate import Z_95
from spiraltrunk.calibration.joint_bench_csv import StaticLoads, load_ring_down, load_static_loads
from spiraltrunk.calibration.joint_bench_fit import Interval, RingFit, StaticFit, fit_ring_down, fit_static
from spiraltrunk.calibration.parameters import BenchStiffness
from spiraltrunk.design.rules import GRAVITY
from spiraltrunk.errors import ModelError, TakeError
from spiraltrunk.files.atomic import write_text
from spiraltrunk.files.output_folder import OutputFolder, open_output
from spiraltrunk.files.results import format_json, read_versions, to_json
from spiraltrunk.report import joint_bench_plot
from spiraltrunk.report.style import write_figure

WRITER = "calibrate --bench"
"""Name of the command in output folders."""

BENCH_PLOT = "bench.png"
"""File of the plot."""

FILES = (BENCH_PLOT, "result.json")
"""Files of joint bench records without takes."""

PRIOR_SPREAD = 0.10
"""Standard deviation of the logarithm of a bench stiffness, in addition to its interval [-] (ours: levers and angles
to some percent, and the first cycles soften a print)."""

_MOST_SPREAD = 100.0


@final
@dataclass(frozen=True, kw_only=True)
class RingDownFile:
    """A ring-down record and the inertia that swung."""

    joint: int
    """Joint, 1 at the base."""
    path: str
    """The record."""
    inertia: float
    """Of everything that swings, about the joint [kg m^2]."""
    inertia_spread: float
    """Its standard deviation [kg m^2]."""


@final
@dataclass(frozen=True, kw_only=True)
class RingDown:
    """A ring-down record and its fit."""

    joint: int
    """Joint, 1 at the base."""
    time: np.ndarray
    """Since the first sample, shape (n,) [s]."""
    signal: np.ndarray
    """Recorded signal, shape (n,)."""
    fit: RingFit
    """Damped oscillation fitted to it."""


@final
@dataclass(frozen=True, kw_only=True)
class Bench:
    """Joint bench records with their fits."""

    static: tuple[tuple[StaticLoads, StaticFit], ...]
    """Static loads by joint."""
    ring_downs: tuple[RingDown, ...]
    """Ring-downs."""


def fit_bench(loads: str | None, ring_downs: Sequence[RingDownFile], n_joint: int) -> Bench:
    """Read and fit joint bench records.

    Args:
        loads: file of static loads, if there is one.
        ring_downs: ring-down records.
        n_joint: number of the trunk's joints.

    Raises:
        TakeError: for records that cannot be read or fitted, or are of a joint that the trunk has not.
    """
    loaded, static = () if loads is None else load_static_loads(loads), []
    named = [*((joint.joint, str(loads)) for joint in loaded), *((ring.joint, ring.path) for ring in ring_downs)]
    for number, file in named:
        if number > n_joint:
            raise TakeError(f"it is of joint {number}; allowed: 1 to {n_joint}, as the design", file=file)
    for joint in loaded:
        try:
            static.append((joint, fit_static(joint.bend, joint.mass, joint.lever_arm)))
        except ModelError as error:
            raise TakeError(f"joint {joint.joint}: {error}", file=str(loads)) from None
    return Bench(static=tuple(static), ring_downs=tuple(map(_fit_ring_down, ring_downs)))


def _fit_ring_down(record: RingDownFile) -> RingDown:
    time, signal = load_ring_down(record.path)
    try:
        fit = fit_ring_down(time, signal, record.inertia, record.inertia_spread)
    except ModelError as error:
        raise TakeError(f"joint {record.joint}: {error}", file=record.path) from None
    return RingDown(joint=record.joint, time=time - time[0], signal=signal, fit=fit)


def compute_prior(bench: Bench) -> tuple[BenchStiffness, ...]:
    """Prior stiffness of the joints with static loads.

    Ring-downs are left out: a print is stiffer when it swings than when it is held, and recorded shapes are held.
    """
    return tuple(
        BenchStiffness(joint=loads.joint, value=fit.stiffness.value, spread=_log_spread(fit.stiffness))
        for loads, fit in bench.static
    )


def _log_spread(interval: Interval) -> float:
    own = (interval.high - interval.low) / (2 * Z_95 * interval.value)
    return min(math.hypot(PRIOR_SPREAD, own), _MOST_SPREAD)


def summarise_bench(bench: Bench) -> dict[str, Any]:
    """Fits of all records in plain values; SI unless a key names its unit."""
    return {
        "static": [
            {
                "joint": loads.joint, "readings": len(loads.bend), "is_beam": fit.is_beam,
                "beam_law_nm_per_rad": _to_dict(fit.beam), "stiffness_nm_per_rad": _to_dict(fit.stiffness),
                "onset_nm": _to_dict(fit.onset), "faces_nm_per_rad": _to_dict(fit.faces),
                "faces_from_deg": _to_dict(fit.faces_from, 180 / math.pi), "beam_law_rms_nm": fit.beam_error,
                "rms_nm": fit.error,
            }
            for loads, fit in bench.static
        ],
        "ring_down": [
            {
                "joint": ring.joint, "samples": len(ring.time), "frequency_hz": _to_dict(ring.fit.frequency),
                "damping_ratio": _to_dict(ring.fit.damping_ratio), "stiffness_nm_per_rad": _to_dict(ring.fit.stiffness),
                "damping_nms_per_rad": _to_dict(ring.fit.damping), "rms": ring.fit.error,
            }
            for ring in bench.ring_downs
        ],
    }  # fmt: skip


def _to_dict(interval: Interval, factor: float = 1.0) -> dict[str, float]:
    return {"value": factor * interval.value, "low_95": factor * interval.low, "high_95": factor * interval.high}


def compute_bench_result(bench: Bench) -> dict[str, Any]:
    """All figures of joint bench records without takes, ready for JSON."""
    return dict(to_json({**summarise_bench(bench), "versions": read_versions("numpy"), "files": []}))


def write_bench_folder(bench: Bench, folder: str | Path | OutputFolder) -> dict[str, Any]:
    """Write plot and result; return the result with its files.

    Raises:
        OutputError: where a file cannot be written or must not be replaced.
    """
    result = compute_bench_result(bench) | {"files": list(FILES)}
    with open_output(folder, WRITER, FILES) as output, output.draft() as draft:
        write_bench_plot(bench, draft / BENCH_PLOT)
        write_text(draft / "result.json", format_json(result) + "\n")
    return result


def write_bench_plot(bench: Bench, path: Path) -> Path:
    """Plot readings and fitted laws of all records.

    Raises:
        OSError: where the file cannot be written.
    """
    loaded: list[joint_bench_plot.LoadedJoint | joint_bench_plot.RingDown] = [
        joint_bench_plot.LoadedJoint(
            name=f"Joint {loads.joint}", bend=loads.bend, moment=GRAVITY * loads.mass * loads.lever_arm,
            beam=fit.beam.value, law=fit.moment, faces_from=fit.faces_from.value,
        )
        for loads, fit in bench.static
    ]  # fmt: skip
    loaded += [
        joint_bench_plot.RingDown(
            name=f"Joint {ring.joint}, ring-down", time=ring.time, signal=ring.signal, law=ring.fit.signal
        )
        for ring in bench.ring_downs
    ]
    return write_figure(joint_bench_plot.build_loads_figure(loaded), path)
