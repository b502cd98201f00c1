"""
Export parts and models
=======================

Make one's own trunk: from a few wishes to parts for a printer, checked, and the same robot for MuJoCo.

On the command line the same is::

    spiraltrunk export trunk.toml --parts gripper drums --formats stl mjcf --out made
"""

from __future__ import annotations

import importlib.util
import sys
import tempfile
from pathlib import Path

import mujoco

from spiraltrunk.cad.components.options import MakeOptions
from spiraltrunk.design import design_from_rules
from spiraltrunk.workflows.export.export import Request, export_robot

if importlib.util.find_spec("build123d") is None:
    print("skipped: solids need build123d, pip install 'spiraltrunk[cad]'")
    sys.exit()

trunk = design_from_rules(b=0.16, arm_radius=0.044, turns=1.25, name="mine")
with tempfile.TemporaryDirectory() as folder:
    request = Request(parts=("gripper", "drums"), formats=("stl", "mjcf"), options=MakeOptions(nozzle=0.4))
    result = export_robot(trunk, folder, request)
    model = mujoco.MjModel.from_xml_path(str(Path(folder) / "models" / "trunk.xml"))
    print((Path(folder) / "bom.md").read_text())

for name, check in result["checks"].items():
    print(f"{name}: {1e6 * check['volume_m3']:.1f} cm^3, walls of {1e3 * check['min_wall_m']:.2f} mm and more")
    assert check["holds"]
moving = sum(model.body(f"section_{n + 1:02d}").mass[0] for n in range(trunk.n_section))
assert abs(moving / trunk.section_mass.sum() - 1) < 1e-6, "the model weighs what the design says"
