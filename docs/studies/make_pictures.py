"""Makes the pictures of README and docs again: the nine strategies, the default grasp, where the tip can be."""

from __future__ import annotations

import os
import sys
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
if not os.environ.get("MUJOCO_GL") and not os.environ.get("DISPLAY"):
    os.environ["MUJOCO_GL"] = "egl"

import numpy as np
from PIL import Image

from spiraltrunk import strategies
from spiraltrunk.design import presets
from spiraltrunk.errors import RunError
from spiraltrunk.files.atomic import write_file
from spiraltrunk.model.inverse import workspace
from spiraltrunk.report import write_filmstrip
from spiraltrunk.report.shape.workspace_plot import build_workspace_figure
from spiraltrunk.report.style import write_figure
from spiraltrunk.report.trial.figures import build_run_figure
from spiraltrunk.sim.framing import frame_view
from spiraltrunk.sim.ground_truth import Sample
from spiraltrunk.sim.objects.catalogue import DEFAULT_OBJECT, parse_object
from spiraltrunk.sim.render import render_frames
from spiraltrunk.workflows.grasp.artifacts import compute_series
from spiraltrunk.workflows.grasp.pictures import VIEW, write_strip
from spiraltrunk.workflows.grasp.trial import Trial, run_trial

IMAGES = Path(__file__).parents[1] / "images"

WIDTH = {"strategies.png": 1240, "filmstrip.png": 1240, "overview.png": 1000, "workspace.png": 1000}
"""Width of each picture [pixels]."""

SHEET = replace(VIEW, width=560, height=560)
"""Pictures of the sheet: as near as trunk and object allow."""

SHOWN = {"wrap-vertical": 1, "wrap-oblique": 3, "wrap-oblique-low": 5, "flip-grip": 1, "sweep": 2}
"""Which of a strategy's objects the sheet shows, where not the first."""

PUSHED = {"kick": 0.05, "sweep": 0.08}
"""Way along the ground after which a pushed object is shown [m]."""


def main() -> int:
    """Run the default grasp and draw it."""
    trial = run_trial(presets.PAPER, parse_object(DEFAULT_OBJECT))
    if not trial.verdict.success:
        print(f"make_pictures: the default grasp failed: {trial.verdict.reason}", file=sys.stderr)
        return 1
    with TemporaryDirectory() as made:
        draft = Path(made)
        series = compute_series(trial, DEFAULT_OBJECT)
        write_strip(trial, draft / "filmstrip.png", title=series.title)
        write_figure(build_run_figure(series, "overview.png"), draft / "overview.png")
        draw_workspace(draft / "workspace.png")
        draw_sheet(draft / "strategies.png")
        for name, width in WIDTH.items():
            _shrink(draft / name, width)
        for name in WIDTH:
            write_file(IMAGES / name, (draft / name).read_bytes())
    return 0


def draw_workspace(path: Path) -> None:
    """Where the tip of the hanging trunk can be."""
    title = "Where the tip of the paper's trunk can be, hanging"
    write_figure(build_workspace_figure(workspace.map(presets.PAPER), title=title), path)


def draw_sheet(path: Path) -> None:
    """One telling moment of each strategy, in the paper's order, each from a trial that succeeded."""
    frames, captions = [], []
    for name in sorted(strategies.NAMES, key=lambda name: strategies.get(name).number):
        strategy = strategies.get(name)
        trial = find_success(name, strategy.objects[SHOWN.get(name, 0)])
        sample = find_moment(trial)
        view = frame_view(trial.plant.model, [sample.qpos], SHEET)
        frames.extend(render_frames(trial.plant.model, [sample.qpos], view))
        captions.append(f"{strategy.number}  {name}")
    write_filmstrip(path, frames, captions, columns=3)


def find_success(name: str, shown: str, most: int = 8) -> Trial:
    """The first trial that succeeds, from seed 0 on.

    Raises:
        RunError: where none of the first does.
    """
    for seed in range(most):
        trial = run_trial(presets.PAPER, parse_object(shown), strategy=name, seed=seed)
        if trial.verdict.success:
            return trial
        print(f"make_pictures: {name}, {shown}, seed {seed}: {trial.verdict.reason}", file=sys.stderr)
    raise RunError(f"{name} fails with {shown} in all of seeds 0 to {most - 1}")


def find_moment(trial: Trial) -> Sample:
    """Held up in the air, or on its way along the ground."""
    trace = trial.plant.trace
    if trial.strategy not in PUSHED:
        span = trial.log.span("transport", "hold")
        return next(sample for sample in trace if span is not None and sample.time >= sum(span) / 2)
    start = trace[0].object_position
    return next(s for s in trace if np.linalg.norm(s.object_position - start) > PUSHED[trial.strategy])


def _shrink(path: Path, width: int) -> None:
    """Small enough for a page."""
    with Image.open(path) as picture:
        small = picture.convert("RGB").resize((width, round(picture.height * width / picture.width)), Image.LANCZOS)
    small.save(path, optimize=True)


if __name__ == "__main__":
    sys.exit(main())
