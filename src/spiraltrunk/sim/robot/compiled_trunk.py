"""Quantities of a design, measured on MuJoCo's compiled trunk."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.sim.robot.trunk import TrunkOptions, section_name, trunk_spec


def measure_compiled(design: TrunkDesign) -> dict[str, Any]:
    """Section lengths, masses, centres and inertias, stroke of cable 1 and largest error of a hole, in SI.

    The holes lie in the faces here; the grasp simulation sets them back (`TrunkOptions`).
    """
    model = trunk_spec(design, TrunkOptions(hole_set_back=0.0)).compile()
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    bodies = [model.body(section_name(n)).id for n in range(design.n_section)]
    starts = model.body_pos[bodies[1:], 0]
    end = model.site(f"end_{design.n_section:02d}").pos[0]
    ids = [
        [[model.site(f"hole_{n + 1:02d}_{c + 1}{side}").id for side in "pd"] for c in range(design.n_cable)]
        for n in range(design.n_section)
    ]
    hole, site = model.site_pos[ids], data.site_xpos[ids]
    ring = np.hypot(hole[..., 1], hole[..., 2])
    error = np.abs(np.stack([hole[..., 0], ring], axis=-1) - design.hole_position[:, None])
    moments = np.sort(model.body_inertia[bodies])
    is_long = design.section_inertia[:, 0] <= design.section_inertia[:, 1]  # Then the axial moment is the least.
    inertia = np.where(is_long[:, None], moments[:, [0, 2]], moments[:, [2, 0]])
    return {
        "length": np.append(starts, end),
        "mass": model.body_mass[bodies],
        "center": model.body_ipos[bodies, 0],
        "inertia": inertia,
        "stroke": float(np.linalg.norm(site[1:, 0, 0] - site[:-1, 0, 1], axis=-1).sum()),
        "hole": float(error.max()),
    }
