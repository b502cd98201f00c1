"""Franka's Panda, also called Franka Emika Robot (FER).

Kinematics and limits: Franka Control Interface documentation. Inertias: Gaz, Cognetti, Oliva, Robuffo Giordano, De
Luca, "Dynamic Identification of the Franka Emika Panda Robot with Retrieval of Feasible Parameters Using Penalty-Based
Optimization", RA-L 2019, as published in franka_description. Meshes: gymnasium-robotics.
"""

from __future__ import annotations

import importlib.util
import math
from pathlib import Path

import numpy as np

from spiraltrunk.control.arm_limits import ArmLimits
from spiraltrunk.errors import MissingPackage
from spiraltrunk.sim.robot.arm_description import ArmDescription, LinkInertia


def find_meshes() -> Path:
    """Folder of the Panda's meshes; the package is not imported, as its import prints a notice.

    Raises:
        MissingPackage: where it is not installed.
    """
    found = importlib.util.find_spec("gymnasium_robotics")
    if found is None or not found.submodule_search_locations:
        raise MissingPackage("the Panda's meshes are missing: pip install gymnasium-robotics")
    folder = Path(next(iter(found.submodule_search_locations)))
    return folder / "envs" / "assets" / "kitchen_franka" / "franka_assets" / "meshes"


_DH = (
    (0.0, 0.333, 0.0), (0.0, 0.0, -math.pi / 2), (0.0, 0.316, math.pi / 2), (0.0825, 0.0, math.pi / 2),
    (-0.0825, 0.384, -math.pi / 2), (0.0, 0.0, math.pi / 2), (0.088, 0.0, math.pi / 2),
)  # fmt: skip
"""Rows a [m], d [m], alpha [rad] (Franka Control Interface documentation, "Denavit-Hartenberg parameters")."""

_INERTIA = (
    (0.629769, (-0.041018, -0.00014, 0.049974), (0.00315, 0.00388, 0.004285, 8.2904e-7, 0.00015, 8.2299e-6)),
    (4.970684, (0.003875, 0.002081, -0.04762), (0.70337, 0.70661, 0.009117, -0.000139, 0.006772, 0.019169)),
    (0.646926, (-0.003141, -0.02872, 0.003495), (0.007962, 0.02811, 0.025995, -0.003925, 0.010254, 0.000704)),
    (3.228604, (0.027518, 0.039252, -0.066502), (0.037242, 0.036155, 0.01083, -0.004761, -0.011396, -0.012805)),
    (3.587895, (-0.05317, 0.104419, 0.027454), (0.025853, 0.019552, 0.028323, 0.007796, -0.001332, 0.008641)),
    (1.225946, (-0.011953, 0.041065, -0.038437), (0.035549, 0.029474, 0.008627, -0.002117, -0.004037, 0.000229)),
    (1.666555, (0.060149, -0.014117, -0.010517), (0.001964, 0.004354, 0.005433, 0.000109, -0.001158, 0.000341)),
    (0.735522, (0.010517, -0.004252, 0.061597), (0.012516, 0.010027, 0.004815, -0.000428, -0.001196, -0.000741)),
)
"""Mass [kg], centre [m] and moments [kg m^2] of links 0 to 7 (Gaz et al. 2019; link 0: franka_description)."""

_RANGE = np.array([
    (-2.8973, 2.8973), (-1.7628, 1.7628), (-2.8973, 2.8973), (-3.0718, -0.0698), (-2.8973, 2.8973), (-0.0175, 3.7525),
    (-2.8973, 2.8973),
])  # fmt: skip
"""Joint ranges [rad] (Franka Control Interface documentation, "Limits for Panda", as are all its limits)."""

PANDA = ArmDescription(
    name="panda",
    dh=_DH,
    flange=0.107,  # The same table.
    inertia=tuple(LinkInertia(mass=mass, center=center, moments=moments) for mass, center, moments in _INERTIA),
    armature=(0.1,) * 7,  # Ours.
    limits=ArmLimits(
        position=(_RANGE[:, 0], _RANGE[:, 1]),
        velocity=np.array([2.175, 2.175, 2.175, 2.175, 2.61, 2.61, 2.61]),
        acceleration=np.array([15.0, 7.5, 10.0, 12.5, 15.0, 20.0, 20.0]),
        jerk=np.array([7500.0, 3750.0, 5000.0, 6250.0, 7500.0, 10000.0, 10000.0]),
        torque=np.array([87.0, 87.0, 87.0, 87.0, 12.0, 12.0, 12.0]),
    ),
    gains=((4500, 450), (4500, 450), (3500, 350), (3500, 350), (2000, 200), (2000, 200), (2000, 200)),  # Ours.
    home=(0.0, -math.pi / 4, 0.0, -3 * math.pi / 4, 0.0, math.pi / 2, math.pi / 4),  # Start of libfranka's examples.
    payload=3.0,  # Data sheet of the Franka Emika robot.
    find_meshes=find_meshes,
)
"""The Panda."""
