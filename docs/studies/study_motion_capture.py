"""Effect of alignment and model on the error of synthetic takes: figures of validation/motion_capture.md.

The packaged protocol is rehearsed: the equilibrium's shapes, without friction, are recorded by made-up cameras with
0.3 mm of noise on 15 sections, written as Motive CSV, and held against both models. Nothing of it is a measurement.
"""

from __future__ import annotations

import json
import re
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from spiraltrunk.design.presets import PAPER
from spiraltrunk.files.atomic import atomic_file
from spiraltrunk.mocap.protocol.protocol import Protocol, sort_takes
from spiraltrunk.mocap.protocol.schedule import build_schedule
from spiraltrunk.mocap.protocol.toml import load_protocol
from spiraltrunk.mocap.recordings.motive_write import write_motive
from spiraltrunk.mocap.session.prediction import predict
from spiraltrunk.mocap.session.session import SessionSettings
from spiraltrunk.mocap.signal.registration import Motion
from spiraltrunk.workflows.validate.artifacts import write_comparison
from spiraltrunk.workflows.validate.comparison import compare_to_model, compute_result
from spiraltrunk.workflows.virtual_session.synthetic_take import CameraOptions, build_synthetic_take

DOCS = Path(__file__).parents[1]
NOISE = 3e-4
PICTURES = {"overlay-bend-dorsal.png": "mocap_overlay.png", "boxes-bend-dorsal.png": "mocap_boxes.png"}


def rehearse(protocol: Protocol, folder: Path) -> list[str]:
    """Files of made-up recordings of all runs."""
    files = []
    for run in protocol.runs:
        shapes = predict(PAPER, build_schedule(PAPER, protocol, run), model="statics", friction=0.0)
        for take in range(run.takes):
            turn = Rotation.from_euler("y", 40.0 + 70.0 * take, degrees=True).as_matrix()
            rehearsal = CameraOptions(
                noise=NOISE, frame=Motion(rotation=turn, shift=np.array([0.4, 1.5, -2.0])), seed=take,
                sections=tuple(range(1, 16)),
            )  # fmt: skip
            path = folder / f"{run.name}_{take + 1}.csv"
            recorded = build_synthetic_take(PAPER, shapes.points, shapes.rotation, run.theta_0, rehearsal)
            files.append(str(write_motive(recorded, path)))
    return files


def measure(protocol: Protocol, images: Path | None = None) -> dict[str, Any]:
    """Mean RMSE of every run by model and alignment [m]; pictures where a folder is given."""
    figures: dict[str, Any] = {"noise_m": NOISE, "mean_rmse_by_alignment_m": {}}
    with tempfile.TemporaryDirectory() as folder:
        takes = sort_takes(protocol, rehearse(protocol, Path(folder)))
        for model in ("reference", "statics"):
            found = compare_to_model(protocol, takes, SessionSettings(design=PAPER, axes="y-up", model=model))
            figures["mean_rmse_by_alignment_m"][model] = compute_result(found)["mean_rmse_by_alignment_m"]
            if images is not None and model == "reference":
                write_comparison(found, Path(folder) / "out")
                for name, kept in PICTURES.items():
                    with atomic_file(images / kept) as draft:
                        draft.write_bytes((Path(folder) / "out" / name).read_bytes())
    return figures


def format_table(figures: dict[str, Any]) -> str:
    """Mean RMSE in mm, a row for each run."""
    by_model = figures["mean_rmse_by_alignment_m"]
    columns = [(model, kind) for model in by_model for kind in by_model[model]]
    head = "| mean RMSE [mm] | " + " | ".join(f"{model}, {kind}" for model, kind in columns) + " |"
    rows = [
        f"| {run} | " + " | ".join(f"{1e3 * by_model[model][kind][run]:.2f}" for model, kind in columns) + " |"
        for run in by_model["reference"]["run"]
    ]
    return "\n".join([head, "|" + " --- |" * (len(columns) + 1), *rows])


def fill_page(page: str, figures: dict[str, Any]) -> str:
    """The page with the table of these figures."""
    marks = "<!-- table rehearsal -->", "<!-- end -->"
    return re.sub(
        f"{marks[0]}.*?{marks[1]}", lambda _: f"{marks[0]}\n{format_table(figures)}\n{marks[1]}", page, flags=re.S
    )


def main() -> None:
    """Measure, and write page, numbers and pictures."""
    figures = measure(load_protocol("paper"), DOCS / "images")
    (DOCS / "studies" / "motion_capture.json").write_text(json.dumps(figures, indent=2) + "\n")
    page = DOCS / "validation" / "motion_capture.md"
    page.write_text(fill_page(page.read_text(), figures))


if __name__ == "__main__":
    main()
