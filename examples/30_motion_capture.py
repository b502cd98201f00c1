"""
Compare a recording with the models
===================================

Hold a recording of motion capture against the paper's model and against the equilibrium.

There is no recording here, so one is made up first: the equilibrium's shapes, seen with 0.3 mm of noise by cameras that
stand anywhere. It is a rehearsal, never a measurement. With recordings of one's own the same is, on the command line::

    spiraltrunk validate bend-dorsal_1.csv bend-dorsal_2.csv --protocol protocol.toml --axes y-up --out out/validate
"""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np

from spiraltrunk.design import presets
from spiraltrunk.mocap import Protocol, Run, SessionSettings, build_session, compute_deviation
from spiraltrunk.mocap.protocol.schedule import build_schedule
from spiraltrunk.mocap.recordings.motive_write import write_motive
from spiraltrunk.mocap.session.prediction import predict
from spiraltrunk.mocap.signal.registration import Motion
from spiraltrunk.workflows.virtual_session.synthetic_take import CameraOptions, build_synthetic_take

trunk = presets.get("paper")
run = Run(name="bend", kind="bend-dorsal", steps=6, step=0.02, takes=2)
protocol = Protocol(name="rehearsal", runs=(run,), axes="y-up")

truth = predict(trunk, build_schedule(trunk, protocol, run), model="statics")
cameras = Motion(
    rotation=np.array([[0.6, 0.0, 0.8], [0.0, 1.0, 0.0], [-0.8, 0.0, 0.6]]), shift=np.array([0.3, 1.4, -2.0])
)
errors = {}
with tempfile.TemporaryDirectory() as folder:
    files = []
    for take in (1, 2):
        rehearsal = CameraOptions(noise=3e-4, frame=cameras, sections=tuple(range(1, 16)), seed=take)
        recorded = build_synthetic_take(trunk, truth.points, truth.rotation, run.theta_0, rehearsal)
        files.append(write_motive(recorded, Path(folder) / f"bend_{take}.csv"))
    for model in ("reference", "statics"):
        session = build_session(protocol, {"bend": files}, SessionSettings(design=trunk, model=model))
        found = session.runs[0]
        errors[model] = compute_deviation(found.points, found.predicted.points)

for model, error in errors.items():
    print(f"{model}: mean RMSE {1e3 * error.mean_rmse:.2f} mm, largest deviation {1e3 * error.max_deviation:.2f} mm")
assert errors["statics"].max_deviation < 3e-4, "the model that made the shapes fits them but for the noise"
assert errors["reference"].mean_rmse > 3e-3, "the models are millimetres apart, whatever the cameras do"
