"""A calibration from recordings to files: read, fitted, judged, and written all together or not at all."""

from __future__ import annotations

import filecmp
import json
import math
import platform
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from importlib.metadata import version
from pathlib import Path
from typing import Any, final

import numpy as np

import spiraltrunk
from spiraltrunk.benched import Bench, tell_bench, write_bench_plot
from spiraltrunk.calibration.calibrate import Calibration, Errors, Settings, calibrate
from spiraltrunk.calibration.identifiability import advise, find_tied, find_untold
from spiraltrunk.design.toml import write_design
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import TakeError
from spiraltrunk.files.atomic import write_folder
from spiraltrunk.mocap.protocol.protocol import Protocol
from spiraltrunk.mocap.session.session import SessionSettings, build_session
from spiraltrunk.mocap.session.shapes_json import write_shapes
from spiraltrunk.mocap.signal.registration import Alignment
from spiraltrunk.model.kinematics.measured_shapes import MeasuredShapes
from spiraltrunk.report.calibration_plot import Bars, write_calibration

FILES = ("trunk.toml", "calibration.png", "shapes.json", "result.json")
"""What a calibration leaves behind."""

BENCH_FILE = "bench.png"
"""What it leaves behind besides, where there were bench records."""

_VIRTUAL = ("virtual", "rehearsal", "simulat")


@final
@dataclass(frozen=True, kw_only=True)
class Recordings:
    """Which recordings are fitted, which are held out, and how they are read."""

    protocol: Protocol
    """What was done."""
    design: TrunkDesign
    """The trunk as it was built."""
    fitted: Mapping[str, Sequence[str]]
    """Files by run."""
    held_out: Mapping[str, Sequence[str]] = field(default_factory=dict)
    """Files by run; each is a take of its own here, never averaged with what is fitted."""
    axes: str | None = None
    """Axis convention; None takes the protocol's."""


def split_takes(takes: Mapping[str, Sequence[str]]) -> tuple[dict[str, list[str]], dict[str, list[str]]]:
    """The last take of every run that has several is held out, the others are fitted."""
    fitted = {run: list(files[:-1]) if len(files) > 1 else list(files) for run, files in takes.items()}
    return fitted, {run: [files[-1]] for run, files in takes.items() if len(files) > 1}


def read_recordings(recordings: Recordings) -> tuple[MeasuredShapes, np.ndarray, tuple[str, ...]]:
    """All shapes, registered by the base's rigid body, which are fitted, and what was odd in the recordings.

    The base alone is no model's word: a registration to a model would hide what is to be fitted.

    Raises:
        TakeError: for recordings that cannot be read or do not hold what the protocol says.
    """
    _refuse_copies(recordings)
    settings = SessionSettings(design=recordings.design, axes=recordings.axes, alignment=Alignment(kind="base"))
    sessions = [
        build_session(recordings.protocol, takes, settings)
        for takes in (recordings.fitted, recordings.held_out)
        if any(takes.values())
    ]
    parts = [session.shapes for session in sessions]
    count = [len(part.kind) for part in parts]
    odd = tuple(note for session in sessions for run in session.runs for note in run.notes)
    return join_shapes(parts), np.arange(sum(count)) < count[0], odd


def _refuse_copies(recordings: Recordings) -> None:
    """A copy of what is fitted judges nothing.

    Raises:
        TakeError: names both.
    """
    for held in _list(recordings.held_out):
        for fitted in _list(recordings.fitted):
            with suppress(OSError):  # What cannot be read is told where it is read.
                if filecmp.cmp(held, fitted, shallow=False):
                    told = f"it is held out and the same file as {fitted!r}, which is fitted"
                    raise TakeError(f"{told}; allowed: each recording once", file=held)


def join_shapes(parts: Sequence[MeasuredShapes]) -> MeasuredShapes:
    """Shapes of several sessions of one trunk, one after the other."""
    firsts = np.cumsum([0, *(len(part.kind) for part in parts[:-1])])
    follows = [np.where(part.follows < 0, -1, part.follows + first) for part, first in zip(parts, firsts, strict=True)]
    arrays = {
        name: np.concatenate([getattr(part, name) for part in parts])
        for name in ("theta_0", "pull", "points", "rotation")
    }
    return MeasuredShapes(
        kind=tuple(kind for part in parts for kind in part.kind), seat=parts[0].seat,
        take=tuple(take for part in parts for take in part.take), follows=np.concatenate(follows), **arrays,
    )  # fmt: skip


def run_calibration(
    recordings: Recordings, settings: Settings, *, tell: Callable[[str, int, int], None] | None = None
) -> tuple[Calibration, MeasuredShapes, tuple[str, ...]]:
    """Read, fit and judge; beside the fit the shapes and what was odd in the recordings.

    Raises:
        TakeError: for recordings that cannot be read.
        ModelError: for shapes that cannot be fitted.
    """
    if tell is not None:
        tell("reading", 0, 1)
    shapes, is_fitted, odd = read_recordings(recordings)
    return calibrate(recordings.design, shapes, is_fitted, settings, tell=tell), shapes, odd


def compute_result(
    recordings: Recordings,
    known: tuple[Settings, Bench | None],
    found: Calibration,
    shapes: MeasuredShapes,
    odd: Sequence[str] = (),
) -> dict[str, Any]:
    """Everything in plain values, ready for JSON; SI but where a key wears its unit."""
    settings, bench = known
    untold = [parameter.name for parameter in find_untold(found)]
    return {
        "design": recordings.design.name,
        "protocol": recordings.protocol.name,
        "parameters": {
            p.name: {
                "unit": p.unit, "before": p.before, "value": p.value, "low_95": p.low, "high_95": p.high,
                "width_over_prior": p.width_ratio, "is_told": p.is_told,
            }
            for p in found.parameters
        },
        "not_told": untold,
        "told_together": [{"names": [a, b], "correlation": c} for a, b, c in find_tied(found)],
        "to_record": list(advise(found, was_weighed=settings.weighing is not None or bool(settings.bench))),
        "fitted": _tell_errors(found.fitted, shapes),
        "held_out": _tell_errors(found.held_out, shapes),
        "bench": None if bench is None else tell_bench(bench),
        "noise_m": found.fit.scatter.noise,
        "discrepancy_at_tip_m": found.fit.scatter.discrepancy,
        "points_that_count_less": found.fit.far,
        "is_settled": found.fit.is_settled,
        "shapes_not_solved": found.unsolved,
        "takes": {"fitted": _list(recordings.fitted), "held_out": _list(recordings.held_out)},
        "paper": {"reference_mean_rmse_m": 0.01041, "what": "the authors' model against their robot, bending"},
        "notes": _notes(recordings, found),
        "odd_in_recordings": list(odd),
        "versions": {
            "spiraltrunk": spiraltrunk.__version__, "python": platform.python_version(), "numpy": version("numpy"),
        },
        "files": [],
    }  # fmt: skip


def write_calibration_folder(
    recordings: Recordings,
    result: dict[str, Any],
    found: tuple[Calibration, MeasuredShapes, Bench | None],
    folder: str | Path,
) -> dict[str, Any]:
    """Write the new design with where it comes from, pictures, shapes and figures; the result with its files.

    Raises:
        OSError: where the folder cannot be written.
    """
    calibration, shapes, bench = found
    told = {**result, "files": [*FILES, *([] if bench is None else [BENCH_FILE])]}
    with write_folder(folder, (*FILES, BENCH_FILE)) as draft:
        if bench is not None:
            write_bench_plot(bench, draft / BENCH_FILE)
        named = replace(calibration.design, name=f"{calibration.design.name}, calibrated"[:200])
        write_design(named, draft / "trunk.toml", provenance(result, calibration))
        write_calibration(_title_bars(recordings, calibration, shapes), draft / "calibration.png")
        write_shapes(shapes, draft / "shapes.json")
        (draft / "result.json").write_text(json.dumps(told, indent=2, allow_nan=False) + "\n")
    return told


def provenance(result: dict[str, Any], found: Calibration) -> list[str]:
    """Where the numbers of a calibrated design come from, as lines of comment."""
    takes = [Path(name).name for name in result["takes"]["fitted"]]
    held = result["held_out"].get("all", {}).get("calibrated_mean_rmse_m")
    slack = ", ".join(f"{1e3 * value:.2f}" for value in found.slack)
    notes = [f"Calibrated by spiraltrunk {result['versions']['spiraltrunk']} from the design {result['design']!r}."]
    notes += [f"Note: {note}." for note in result["notes"]]
    notes.append(f"Fitted to {len(takes)} takes: {', '.join(takes)}"[:400] + ".")
    notes.append("Held-out mean RMSE: " + ("none was held out." if held is None else f"{1e3 * held:.2f} mm."))
    notes.append(
        f"Slack of the cables, which is no part of a design: {slack} mm. For sessions still to be recorded put it into "
        "the protocol's slack_mm, never for these takes; `validate` takes slack as made up for."
    )
    notes.append(f"Give of winder and cable, which is no part of a design: {1e3 * found.give:.3g} mm/N.")
    if result["not_told"]:
        notes.append(f"Not told by the takes, and near what was known beforehand: {', '.join(result['not_told'])}.")
    return notes


def build_bars(design: TrunkDesign, found: Calibration, shapes: MeasuredShapes) -> Bars:
    """What the picture of a calibration shows."""
    joints = found.parameters[: design.n_joint]
    errors = found.held_out if len(found.held_out.index) else found.fitted
    groups = _group(errors, shapes)
    rows = [[_mean(getattr(errors, model)[own]) for model in _MODELS] for own in groups.values()]
    return Bars(
        before=design.joint_stiffness, value=np.array([p.value for p in joints]),
        low=np.array([p.low for p in joints]), high=np.array([p.high for p in joints]),
        groups=tuple(groups), errors=np.array([[math.nan if v is None else v for v in row] for row in rows]),
        is_held_out=bool(len(found.held_out.index)),
    )  # fmt: skip


def _title_bars(recordings: Recordings, found: Calibration, shapes: MeasuredShapes) -> Bars:
    made = any(_is_virtual(file) for file in (*_list(recordings.fitted), *_list(recordings.held_out)))
    words = f"Calibration of {recordings.design.name}" + (", virtual capture: not a measurement" if made else "")
    return replace(build_bars(recordings.design, found, shapes), title=words)


_MODELS = ("calibrated", "uncalibrated", "reference")


def _group(errors: Errors, shapes: MeasuredShapes) -> dict[str, np.ndarray]:
    """Which errors belong to which kind of shape, at rest by tilt."""
    names = [
        f"{shapes.kind[i]} {90 - math.degrees(shapes.theta_0[i]):.0f} deg"
        if shapes.kind[i] == "rest"
        else shapes.kind[i]
        for i in errors.index
    ]
    return {name: np.array([other == name for other in names]) for name in dict.fromkeys(names)}


def _tell_errors(errors: Errors, shapes: MeasuredShapes) -> dict[str, Any]:
    """Means of the shapes' RMSE by kind, and over all."""
    if not len(errors.index):
        return {}
    groups = {**_group(errors, shapes), "all": np.ones(len(errors.index), bool)}
    return {
        name: {"shapes": int(own.sum())}
        | {f"{model}_mean_rmse_m": _mean(getattr(errors, model)[own]) for model in _MODELS}
        for name, own in groups.items()
    }


def _mean(values: np.ndarray) -> float | None:
    return float(np.nanmean(values)) if np.isfinite(values).any() else None


def _list(takes: Mapping[str, Sequence[str]]) -> list[str]:
    return [str(file) for files in takes.values() for file in files]


def _notes(recordings: Recordings, found: Calibration) -> list[str]:
    notes = []
    files = [*_list(recordings.fitted), *_list(recordings.held_out)]
    made = [file for file in files if _is_virtual(file)]
    if made:
        notes.append(f"not a measurement: {len(made)} of {len(files)} recordings are made up")
    if len(find_untold(found)) == len(found.parameters):
        notes.append("nothing was calibrated: these takes tell no parameter")
    if not recordings.held_out:
        notes.append("nothing was held out: the error on unseen shapes is not known")
    if not found.fit.is_settled:
        notes.append("the search ended before the misfit had ceased to fall")
    if found.unsolved:
        notes.append(f"{found.unsolved} shapes did not converge")
    return notes


def _is_virtual(file: str) -> bool:
    """Whether a take's first line says that it is made up."""
    try:
        with Path(file).open("rb") as stream:
            head = stream.read(600).lower()
    except OSError:
        return False
    return any(word.encode() in head for word in _VIRTUAL)
