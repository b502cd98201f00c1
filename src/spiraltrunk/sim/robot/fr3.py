"""Franka Research 3 (FR3).

Kinematics and limits: Franka, "Control Interface Specification and Robot Limits", edition with position-based velocity
limits (earlier editions give narrower joint ranges). Inertias: franka_description, robot fr3. Rotor inertias: MuJoCo
Menagerie, model franka_fr3, identified there under torque control. Payload: data sheet of Franka Research 3.

No dependency contains the FR3's meshes. The arm is drawn and collides as the capsules of Franka's self-collision check,
which have the axes and thickness of the links, not their outlines: pictures and contacts of the arm are coarse.
"""

from __future__ import annotations

import math

import numpy as np

from spiraltrunk.control.arm_limits import ArmLimits
from spiraltrunk.sim.robot.arm_description import ArmDescription, Capsule, LinkInertia
from spiraltrunk.sim.robot.panda import PANDA

_INERTIA = (
    (2.3966, (-0.0172, 0.0004, 0.0745), (0.0090, 0.0115, 0.0085, 0.0, 0.0020, 0.0)),
    (2.9274653454, (4.128e-7, -0.0181251324, -0.0386035970),
     (0.023927316485107913, 0.0224821613275756, 0.006350098258530016,
      1.3317903455714081e-05, -0.00011404774918616684, -0.0019950320628240115)),
    (2.9355370338, (0.0031828864, -0.0743221644, 0.0088146084),
     (0.041938946257609425, 0.02514514885014724, 0.06170214472888839,
      0.00020257331521090626, 0.004077784227179924, -0.0042252158006570156)),
    (2.2449013699, (0.0407015686, -0.0048200565, -0.0289730823),
     (0.02410142547240885, 0.01974053266708178, 0.019044494482244823,
      0.002404694559042109, -0.002856269270114313, -0.002104212683891874)),
    (2.6155955791, (-0.0459100965, 0.0630492960, -0.0085187868),
     (0.03452998321913202, 0.028881621933049058, 0.04125471171146641,
      0.01322552265982813, 0.01015142998484113, -0.0009762833870704552)),
    (2.3271207594, (-0.0016039605, 0.0292536262, -0.0972965990),
     (0.051610278463662895, 0.04787729713371481, 0.016423625579357254,
      -0.005715173387783472, -0.0035673167625872135, 0.010673985108535986)),
    (1.8170376524, (0.0597131221, -0.0410294666, -0.0101692726),
     (0.005412333594383447, 0.014058329545509979, 0.016080817924212554,
      0.006193456360285834, 0.0014219289306117652, -0.0013140753741120031)),
    (0.6271432862, (0.0045225817, 0.0086261921, -0.0161633251),
     (0.00021092389150104718, 0.00017718568002411474, 5.993190599659971e-05,
      -2.433299114461931e-05, 4.564480393778983e-05, 8.744070223226438e-05)),
)  # fmt: skip
"""Mass [kg], centre [m] and moments xx, yy, zz, xy, xz, yz [kg m^2] of links 0 to 7 (franka_description)."""

_RANGE = np.array([
    (-2.9007, 2.9007), (-1.8361, 1.8361), (-2.9007, 2.9007), (-3.0770, -0.1169), (-2.8763, 2.8763), (0.4398, 4.6216),
    (-3.0508, 3.0508),
])  # fmt: skip
"""Joint ranges [rad] (Franka's specification, "Limits for Franka Research 3", as are all its limits)."""

_DIAGONAL = math.sqrt(0.5)
"""Component of the direction of link 7's side capsule, at 45 deg between the link's axes [-]."""

_CAPSULES = (
    (Capsule(first=(-0.09, 0.0, 0.06), second=(-0.06, 0.0, 0.06), radius=0.06),),
    # Published from -0.333; moved up by 60 mm, as its lower cap would reach below the arm's base.
    (Capsule(first=(0.0, 0.0, -0.273), second=(0.0, 0.0, -0.05), radius=0.06),),
    (Capsule(first=(0.0, 0.0, -0.06), second=(0.0, 0.0, 0.06), radius=0.06),),
    (Capsule(first=(0.0, 0.0, -0.22), second=(0.0, 0.0, -0.07), radius=0.06),),
    (Capsule(first=(0.0, 0.0, -0.06), second=(0.0, 0.0, 0.06), radius=0.06),),
    (Capsule(first=(0.0, 0.0, -0.31), second=(0.0, 0.0, -0.21), radius=0.06),
     Capsule(first=(0.0, 0.08, -0.20), second=(0.0, 0.08, -0.06), radius=0.025)),
    (Capsule(first=(0.0, 0.0, -0.07), second=(0.0, 0.0, 0.01), radius=0.05),),
    (Capsule(first=(0.0, 0.0, -0.06), second=(0.0, 0.0, 0.08), radius=0.04),
     Capsule(first=(0.055 * _DIAGONAL, 0.055 * _DIAGONAL, 0.082),
             second=(0.065 * _DIAGONAL, 0.065 * _DIAGONAL, 0.082), radius=0.03)),
)  # fmt: skip
"""Capsules of links 0 to 7 [m] (franka_description, common arm, self-collision geometries)."""

FR3 = ArmDescription(
    name="fr3",
    dh=PANDA.dh,  # Franka's specification, "Kinematic Configuration".
    flange=PANDA.flange,
    inertia=tuple(LinkInertia(mass=mass, center=center, moments=moments) for mass, center, moments in _INERTIA),
    armature=(0.195,) * 4 + (0.074,) * 3,
    limits=ArmLimits(
        position=(_RANGE[:, 0], _RANGE[:, 1]),
        velocity=np.array([2.62, 2.62, 2.62, 2.62, 5.26, 4.18, 5.26]),
        acceleration=np.full(7, 10.0),
        jerk=np.full(7, 5000.0),
        torque=np.array([87.0, 87.0, 87.0, 87.0, 12.0, 12.0, 12.0]),
        braking=(
            np.array([0.6599, 0.2517, 0.2000, 0.3533, 0.5757, 0.4878, 0.4628]),
            np.array([6.0, 2.585, 3.5, 4.0, 17.0, 5.5, 17.0]),
        ),
    ),
    gains=PANDA.gains,
    home=PANDA.home,
    payload=3.0,
    capsules=_CAPSULES,
)
"""The FR3."""
