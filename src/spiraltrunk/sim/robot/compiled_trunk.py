"""Quantities of MuJoCo's compiled trunk that the design determines, for comparison."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.sim.robot.trunk import TrunkOptions, section_name, trunk_spec


def measure_compiled(design: TrunkDesign) -> dict[str, Any]:
    """Section lengths, masses, centres, inertias, stroke and largest error of a hole of the compiled trunk, in SI.

    The holes are in the faces here; the simulation sets them back a little (`TrunkOptions`).
    """
    model = trunk_spec(design, TrunkOptions(hole_set_back=0.0)).compile()
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    bodies = [model.body(section_name(n)).id for n in range(design.n_section)]
    starts = model.body_pos[bodies[1:], 0]
    end = model.site(f"end_{design.n_section:02d}").pos[0]
    hole = np.array(
        [
            [[model.site(f"hole_{n + 1:02d}_{c + 1}{side}").pos for side in "pd"] for c in range(design.n_cable)]
            for n in range(design.n_section)
        ]
    )
    ring = np.hypot(hole[..., 1], hole[..., 2])
    error = np.abs(np.stack([hole[..., 0], ring], axis=-1) - design.hole_position[:, None])
    moments = np.array([sorted(model.body_inertia[b]) for b in bodies])
    wanted = np.array([sorted([axial, across, across]) for axial, across in design.section_inertia])
    is_flat = wanted[:, 0] == design.section_inertia[:, 0]  # The axial moment is the least of a long section.
    inertia = np.where(is_flat[:, None], moments[:, [0, 2]], moments[:, [2, 0]])
    return {
        "length": np.append(starts, end),
        "mass": model.body_mass[bodies],
        "center": model.body_ipos[bodies, 0],
        "inertia": inertia,
        "stroke": _measure_stroke(model, data, design),
        "hole": float(error.max()),
    }


def _measure_stroke(model: mujoco.MjModel, data: mujoco.MjData, design: TrunkDesign) -> float:
    """Cable 1 across all gaps of the straight trunk [m]."""
    across = 0.0
    for n in range(design.n_joint):
        one = data.site_xpos[model.site(f"hole_{n + 1:02d}_1d").id]
        other = data.site_xpos[model.site(f"hole_{n + 2:02d}_1p").id]
        across += float(np.linalg.norm(other - one))
    return across
