"""What the tests of the simulation share: a trunk alone, at any tilt."""

import math

import mujoco
import numpy as np
import pytest

from spiraltrunk.sim import TrunkOptions
from spiraltrunk.sim.robot.trunk import add_trunk, cable_name, tune_joint_limits


@pytest.fixture(scope="session")
def build_trunk():
    """Build a trunk alone with its base tilted from hanging [deg], solved as in a scene."""

    def build_trunk(design, tilt=0.0, options=None, tuned=True):
        spec = mujoco.MjSpec()
        spec.compiler.degree = False
        spec.compiler.autolimits = True
        spec.option.timestep = 1e-3
        spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
        spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
        spec.option.jacobian = mujoco.mjtJacobian.mjJAC_DENSE
        half = (math.pi - math.radians(tilt)) / 2
        mount = (math.cos(half), 0.0, math.sin(half), 0.0)
        add_trunk(spec, spec.worldbody, design, TrunkOptions() if options is None else options, quat_wxyz=mount)
        model = spec.compile()
        if tuned:
            tune_joint_limits(model, design)
        slacken(model, design)
        return model

    return build_trunk


@pytest.fixture(scope="session")
def pull():
    """Set the cables' tensions [N]: winders that pull in without end, at most so hard."""
    return set_tension


def slacken(model, design):
    set_tension(model, design, np.zeros(design.n_cable))


def set_tension(model, design, tension):
    for c, value in enumerate(tension):
        model.actuator_forcerange[model.actuator(cable_name(c)).id] = (-value, 0.0)
