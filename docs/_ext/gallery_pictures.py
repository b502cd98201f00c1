"""Pictures of the examples: what an example has computed is drawn as the commands draw it.

An example stays free of drawing code. After it has run, what it holds under known names is drawn: a trial as a film
strip (left out without OpenGL) and its overview, a run's log, a session, a calibration, checked parts.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from sphinx_gallery.scrapers import figure_rst

if not os.environ.get("MUJOCO_GL") and not os.environ.get("DISPLAY"):
    os.environ["MUJOCO_GL"] = "egl"

WIDTH = 1200
"""Width of a picture at most [px]."""


def scrape(block: tuple[str, str, int], block_vars: dict[str, Any], gallery_conf: dict[str, Any]) -> str:
    """Draw what an example has left behind; reStructuredText with its pictures."""
    paths: list[str] = []
    left = None
    for draw in _find_drawings(block_vars["example_globals"]):
        path = left or Path(next(block_vars["image_path_iterator"]))
        path.parent.mkdir(parents=True, exist_ok=True)
        left = None if draw(path) else path
        if left is None:
            _shrink(path)
            paths.append(str(path))
    return "".join(figure_rst([path], gallery_conf["src_dir"]) for path in paths)


def _find_drawings(values: dict[str, Any]) -> Iterator[Callable[[Path], bool]]:
    from spiraltrunk.calibration.calibrate import Calibration
    from spiraltrunk.control import RunLog
    from spiraltrunk.mocap.session.session import Session
    from spiraltrunk.workflows.grasp.trial import Trial

    held = list(values.values())
    for value in held:
        if isinstance(value, Trial):
            yield lambda path, trial=value: _draw_strip(trial, path)
            yield lambda path, trial=value: _draw_overview(trial, path)
        elif isinstance(value, RunLog):
            yield lambda path, log=value: _draw_log(log, path)
        elif isinstance(value, Session):
            yield lambda path, session=value: _draw_overlay(session, path)
        elif isinstance(value, Calibration):
            yield lambda path, found=value: _draw_calibration(found, values, path)
    if "result" in values and "checks" in values["result"]:
        yield lambda path: _draw_parts(values["result"], path)


def _draw_strip(trial: Any, path: Path) -> bool:
    from spiraltrunk.errors import SpiralTrunkError
    from spiraltrunk.workflows.grasp.artifacts import write_strip

    try:
        write_strip(trial, path, title=f"{trial.strategy}, seed {trial.seed}")
    except (SpiralTrunkError, ImportError, OSError):
        return False  # No OpenGL here.
    return True


def _draw_overview(trial: Any, path: Path) -> bool:
    from spiraltrunk.report import write_overview
    from spiraltrunk.workflows.grasp.artifacts import compute_series

    write_overview(compute_series(trial, trial.options.shape.kind), path)
    return True


def _draw_log(log: Any, path: Path) -> bool:
    """Change of the force on the trunk's base over a run."""
    from spiraltrunk.report.style import DPI, build_figure

    time = [seen.time for seen in log.observations]
    figure = build_figure(9.0, 3.4, "Change of the force on the trunk's base, from the arm's torques")
    axes = figure.subplots()
    force = np.array([seen.base_force for seen in log.observations])
    for name, column in zip("xyz", (force - force[0]).T, strict=True):
        axes.plot(time, column, label=name)
    axes.set_xlabel("time [s]")
    axes.set_ylabel("force [N]")
    for phase in ("prehension", "release"):
        if (span := log.span(phase)) is not None:
            axes.axvline(span[0], color="0.6", linewidth=0.8)
            axes.annotate(f" {phase}", (span[0], axes.get_ylim()[1]), va="top", fontsize=8)
    axes.legend(loc="lower left")
    figure.savefig(path, dpi=DPI)
    return True


def _draw_overlay(session: Any, path: Path) -> bool:
    from spiraltrunk.report.shape.comparison import Judged
    from spiraltrunk.report.shape.overlay import write_overlay

    run = session.runs[0]
    labels = tuple(str(i) for i in range(len(run.points)))
    write_overlay(
        Judged(title="Measured shapes over the model", labels=labels, label="step", measured=run.points,
               predicted=run.predicted.points),
        path,
    )  # fmt: skip
    return True


def _draw_calibration(found: Any, path: Path) -> bool:
    """Fitted stiffness of each joint with its interval, beside the design's."""
    if not hasattr(found, "parameters"):
        return False
    joints = found.parameters[: found.design.n_joint]
    number = np.arange(1, len(joints) + 1)
    value, low, high = (np.array([getattr(p, name) for p in joints]) for name in ("value", "low", "high"))
    figure, axes = _build("Bending stiffness of each joint", 3.8)
    axes.plot(number, [p.before for p in joints], "--", color="0.5", label="as designed")
    axes.errorbar(number, value, yerr=(value - low, high - value), fmt=".", label="fitted, with 95 % interval")
    axes.set(xlabel="joint, 1 at the base", ylabel="stiffness [N m/rad]", yscale="log")
    axes.legend()
    return _save(figure, path)


def _draw_parts(result: dict[str, Any], path: Path) -> bool:
    """Thinnest wall of each part over what is allowed."""
    if "checks" not in result:
        return False
    names = list(result["checks"])
    figure = build_figure(9.0, 0.9 + 0.32 * len(names), "Thinnest wall of each part")
    axes = figure.subplots()
    axes.barh(names, [1e3 * result["checks"][name]["min_wall_m"] for name in names])
    axes.axvline(0.8, color="0.4", linewidth=0.8)
    axes.annotate(" two nozzles", (0.8, len(names) - 0.5), fontsize=8, va="top")
    axes.set_xlabel("wall [mm]")
    figure.savefig(path, dpi=DPI)
    return True


def _shrink(path: Path) -> None:
    from PIL import Image

    with Image.open(path) as picture:
        if picture.width <= WIDTH:
            return
        small = picture.convert("RGB").resize((WIDTH, round(picture.height * WIDTH / picture.width)), Image.LANCZOS)
    small.save(path, optimize=True)
