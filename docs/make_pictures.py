"""Makes the pictures of README and docs again: film strip and overview of the default grasp, where the tip can be."""

from __future__ import annotations

import os
import sys
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
if not os.environ.get("MUJOCO_GL") and not os.environ.get("DISPLAY"):
    os.environ["MUJOCO_GL"] = "egl"

from PIL import Image

from spiraltrunk.design import presets
from spiraltrunk.model import workspace
from spiraltrunk.record import compute_series, open_record, write_strip
from spiraltrunk.report import write_overview
from spiraltrunk.report.workspace import write_workspace
from spiraltrunk.sim.objects import DEFAULT_OBJECT, parse_object
from spiraltrunk.trial import run_trial

IMAGES = Path(__file__).parent / "images"

WIDTH = {"filmstrip.png": 1240, "overview.png": 1000, "workspace.png": 1000}
"""Width of each picture [pixels]."""


def main() -> int:
    """Run the default grasp and draw it."""
    trial = run_trial(presets.PAPER, parse_object(DEFAULT_OBJECT))
    if not trial.verdict.success:
        print(f"make_pictures: the default grasp failed: {trial.verdict.reason}", file=sys.stderr)
        return 1
    with open_record(IMAGES) as draft:
        series = compute_series(trial, DEFAULT_OBJECT)
        write_strip(trial, draft / "filmstrip.png", title=series.title)
        write_overview(series, draft / "overview.png")
        draw_workspace(draft / "workspace.png")
        for name, width in WIDTH.items():
            _shrink(draft / name, width)
    return 0


def draw_workspace(path: Path) -> None:
    """Where the tip of the hanging trunk can be."""
    write_workspace(workspace.map(presets.PAPER), path, title="Where the tip of the paper's trunk can be, hanging")


def _shrink(path: Path, width: int) -> None:
    """Small enough for a page."""
    with Image.open(path) as picture:
        small = picture.convert("RGB").resize((width, round(picture.height * width / picture.width)), Image.LANCZOS)
    small.save(path, optimize=True)


if __name__ == "__main__":
    sys.exit(main())
