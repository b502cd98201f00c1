"""Jobs of the tab; each function runs in a process of its own."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, final

from spiraltrunk.design import TrunkDesign
from spiraltrunk.mocap.protocol.toml import PACKAGED, load_protocol

if TYPE_CHECKING:
    from spiraltrunk.workflows.validate.comparison import Comparison
    from spiraltrunk.workflows.validate.overlay import RunOverlay

Report = Callable[[tuple[str, int, int]], None]
"""Called with the step, how much of it is done, and the total."""


@final
@dataclass(frozen=True, kw_only=True)
class Question:
    """Recordings, and the model that they are compared with."""

    design: TrunkDesign
    """The trunk."""
    protocol: str
    """Name or file of the protocol."""
    takes: dict[str, list[str]]
    """Files by run."""
    axes: str
    """Axis convention of the recordings."""
    model: str
    """Model to compare with."""
    alignment: str
    """How the recordings are registered."""


def compare_takes(report: Report, question: Question) -> tuple[tuple[RunOverlay, ...], dict[str, Any]]:
    """Overlay of every run, and the figures of ``spiraltrunk validate --json``."""
    from spiraltrunk.workflows.validate.comparison import compute_result
    from spiraltrunk.workflows.validate.overlay import build_overlays

    comparison = _compare(report, question)
    return build_overlays(comparison), compute_result(comparison)


def write_report(report: Report, question: Question, folder: str) -> str:
    """The folder of ``spiraltrunk validate --out``, packed; its path is returned."""
    from spiraltrunk.workflows.validate.artifacts import write_comparison

    comparison = _compare(report, question)
    report(("drawing the report", 0, 1))
    write_comparison(comparison, Path(folder) / "validation")
    return _pack(Path(folder) / "validation")


def record_virtual(report: Report, design: TrunkDesign, run: str, seed: int, folder: str) -> list[str]:
    """Two synthetic takes of a run of the packaged protocol, solved by the equilibrium model; their files.

    ``spiraltrunk calibrate --virtual`` simulates them in MuJoCo, which takes minutes.
    """
    from spiraltrunk.workflows.virtual_session.cameras import select_sections
    from spiraltrunk.workflows.virtual_session.printed_trunk import draw_printed_trunk
    from spiraltrunk.workflows.virtual_session.session import simulate_session, write_session

    select_sections(design)
    packaged = load_protocol(PACKAGED)
    protocol = replace(packaged, runs=(packaged.run(run),))
    report((f"solving {run}", 0, 1))
    trunk = draw_printed_trunk(design, seed)
    runs = simulate_session(design, trunk, protocol, is_simulated=False)
    report(("writing two takes", 0, 1))
    files = write_session(design, runs, seed, folder)
    return [str(file) for file in files if file.suffix == ".csv"]


def calibrate_takes(report: Report, question: Question, mass_g: float, folder: str) -> tuple[dict[str, Any], str, str]:
    """Result of ``spiraltrunk calibrate --json``, the calibrated design's file, and all files packed.

    The last take of every run with several is held out.

    Args:
        report: progress.
        question: design, protocol and recordings.
        mass_g: weighed mass of all sections with the gripper [g]; 0 where it was not weighed.
        folder: temporary folder to write into.
    """
    from spiraltrunk.calibration.calibrate import Settings, Weighing
    from spiraltrunk.workflows.calibrate.artifacts import run_calibration, write_calibration_folder
    from spiraltrunk.workflows.calibrate.recordings import Recordings, split_takes

    fitted, held_out = split_takes(question.takes)
    protocol = load_protocol(question.protocol)
    recordings = Recordings(
        protocol=protocol, design=question.design, fitted=fitted, held_out=held_out, axes=question.axes
    )
    mass = mass_g / 1e3
    settings = Settings(weighing=Weighing(mass=mass, spread=0.01 * mass)) if mass > 0 else Settings()
    run = run_calibration(recordings, settings, progress=_follow(report))
    report(("drawing the report", 0, 1))
    place = Path(folder) / "calibration"
    result = write_calibration_folder(run, place)
    return result, str(place / "trunk.toml"), _pack(place)


def _compare(report: Report, question: Question) -> Comparison:
    from spiraltrunk.mocap.session.session import SessionSettings
    from spiraltrunk.mocap.signal.registration import read_alignment
    from spiraltrunk.workflows.validate.comparison import compare_to_model

    settings = SessionSettings(
        design=question.design, axes=question.axes, model=question.model, alignment=read_alignment(question.alignment)
    )
    return compare_to_model(load_protocol(question.protocol), question.takes, settings, _follow(report))


def _follow(report: Report) -> Callable[[str, int, int], None]:
    return lambda step, done, total: report((step, done, total))


def _pack(folder: Path) -> str:
    return shutil.make_archive(str(folder), "zip", folder)


def list_virtual_runs() -> Sequence[str]:
    """Runs of the packaged protocol, bending first."""
    names = [run.name for run in load_protocol(PACKAGED).runs]
    return sorted(names, key=lambda name: name.startswith("rest"))
