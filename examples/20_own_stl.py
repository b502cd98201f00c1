"""
Grasp an object of your own
===========================

Grasp an object of one's own: an STL, its unit and its mass are all that is needed.

Here the file is made first: a closed vase, 240 mm high and 60 mm wide at its belly. Any watertight STL will do. On the
command line the same is::

    spiraltrunk grasp --object stl:path=vase.stl,unit=mm,mass_g=250
"""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
import trimesh

from spiraltrunk.design import presets
from spiraltrunk.sim.objects.catalogue import load_stl
from spiraltrunk.workflows.grasp.trial import run_trial

with tempfile.TemporaryDirectory() as folder:
    path = Path(folder) / "vase.stl"
    height = np.linspace(0.0, 240.0, 25)
    radius = 24.0 + 6.0 * np.sin(np.pi * height / 240.0)
    outline = np.column_stack([[0.0, *radius, 0.0], [0.0, *height, 240.0]])
    trimesh.creation.revolve(outline, sections=48).export(path)
    vase = load_stl(str(path), unit="mm", mass=0.25)

length, width, _ = vase.size
about_axis, across, _ = np.diag(vase.inertia())
print(f"{1e3 * length:.0f} mm long, {1e3 * width:.0f} mm wide; {1e6 * about_axis:.0f} and {1e6 * across:.0f} kg mm^2")
assert np.allclose(vase.size, (0.240, 0.060, 0.060), rtol=1e-3)
assert not vase.warning, "its convex hull is itself"

trial = run_trial(presets.get("paper"), vase, strategy="wrap-vertical", seed=0)
print(f"{trial.verdict.reason}: lifted {100 * trial.verdict.lift:.0f} cm, held {trial.verdict.hold:.1f} s")
assert trial.verdict.success
