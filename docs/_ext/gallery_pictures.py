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
    """By the names that the examples use."""
    drawings: dict[str, tuple[Callable[[Any, Path], bool], ...]] = {
        "trial": (_draw_strip, _draw_overview),
        "log": (_draw_log,),
        "session": (_draw_session,),
        "found": (_draw_calibration,),
        "result": (_draw_parts,),
    }
    if "session" in values:
        drawings.pop("found")  # One of the session's runs.
    for name, draws in drawings.items():
        for draw in draws if name in values else ():
            yield lambda path, draw=draw, value=values[name]: draw(value, path)


def _draw_strip(trial: Any, path: Path) -> bool:
    from spiraltrunk.errors import SpiralTrunkError
    from spiraltrunk.workflows.grasp.pictures import write_strip

    try:
        write_strip(trial, path, title=f"{trial.strategy}, seed {trial.seed}")
    except (SpiralTrunkError, ImportError, OSError):
        return False  # No OpenGL here.
    return True


def _draw_overview(trial: Any, path: Path) -> bool:
    from spiraltrunk.report.style import write_figure
    from spiraltrunk.report.trial.figures import build_run_figure
    from spiraltrunk.workflows.grasp.artifacts import compute_series

    write_figure(build_run_figure(compute_series(trial, trial.options.shape.kind), "overview.png"), path)
    return True


def _draw_log(log: Any, path: Path) -> bool:
    """Change of the force on the trunk's base over a run."""
    figure, axes = _build("Change of the force on the trunk's base, from the arm's torques", 3.4)
    time = [seen.time for seen in log.observations]
    force = np.array([seen.base_force for seen in log.observations])
    for name, column in zip("xyz", (force - force[0]).T, strict=True):
        axes.plot(time, column, label=name)
    for phase in ("prehension", "release"):
        if (span := log.span(phase)) is not None:
            axes.axvline(span[0], color="0.6", linewidth=0.8)
            axes.annotate(f" {phase}", (span[0], axes.get_ylim()[1]), va="top", fontsize=8)
    axes.set(xlabel="time [s]", ylabel="force [N]")
    axes.legend(loc="lower left")
    return _save(figure, path)


def _draw_session(session: Any, path: Path) -> bool:
    """Measured points over the model's shapes, from the side."""
    run = session.runs[0]
    figure, axes = _build("Measured points (dots) over the predicted shapes (lines), from the side", 5.0)
    for i, (measured, predicted) in enumerate(zip(run.points, run.predicted.points, strict=True)):
        x, y = 1e3 * predicted[:, 0], 1e3 * predicted[:, 1]
        (line,) = axes.plot(x, y, linewidth=1, label=f"step {i}")
        axes.plot(1e3 * measured[:, 0], 1e3 * measured[:, 1], ".", color=line.get_color())
    axes.set(xlabel="x, dorsal [mm]", ylabel="y, up [mm]", aspect="equal")
    axes.legend(loc="center left", bbox_to_anchor=(1.02, 0.5))
    return _save(figure, path)


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
    figure, axes = _build("Thinnest wall of each part", 0.9 + 0.4 * len(names))
    axes.barh(names, [1e3 * result["checks"][name]["min_wall_m"] for name in names])
    axes.axvline(0.8, color="0.4", linewidth=0.8)
    axes.annotate(" two nozzles", (0.8, len(names) - 0.6), fontsize=8, va="top")
    axes.set(xlabel="wall [mm]")
    return _save(figure, path)


def _build(title: str, height: float) -> tuple[Any, Any]:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.0, height), layout="constrained")
    axes = figure.subplots()
    axes.set_title(title, fontsize=10)
    axes.spines[["top", "right"]].set_visible(False)
    return figure, axes


def _save(figure: Any, path: Path) -> bool:
    figure.savefig(path, dpi=130)
    return True


def _shrink(path: Path) -> None:
    from PIL import Image

    with Image.open(path) as picture:
        if picture.width <= WIDTH:
            return
        small = picture.convert("RGB").resize((WIDTH, round(picture.height * WIDTH / picture.width)), Image.LANCZOS)
    small.save(path, optimize=True)
