"""
Calibrate a trunk
=================

Calibrate a trunk that is off its design, without a laboratory.

A virtual trunk, 20 % off in stiffness and 10 % in mass, is played by the equilibrium model: nothing here is a
measurement. On the command line, with recordings or virtual ones, the same is::

    spiraltrunk calibrate --virtual takes
    spiraltrunk calibrate takes/*_1.csv --hold-out takes/bend-dorsal_2.csv --protocol takes/protocol.toml --mass-g 214
"""

from __future__ import annotations

import math

import numpy as np

from spiraltrunk.calibration.calibrate import Settings, Weighing, calibrate
from spiraltrunk.calibration.identifiability import advise
from spiraltrunk.design import presets
from spiraltrunk.mocap.protocol.protocol import Protocol, Run
from spiraltrunk.workflows.virtual_session.printed_trunk import draw_printed_trunk, weigh
from spiraltrunk.workflows.virtual_session.session import measure_session, simulate_session

design = presets.get("paper")
protocol = Protocol(
    name="short",
    runs=(
        Run(name="rest-090", kind="rest", theta_0=0.0),
        Run(name="rest-045", kind="rest", theta_0=math.pi / 4),
        Run(name="bend-dorsal", kind="bend-dorsal", steps=13, step=0.01),
    ),
)
world = draw_printed_trunk(design, seed=4)
shapes = measure_session(design, simulate_session(design, world, protocol, is_simulated=False), seed=4)
mass, spread = weigh(design, world)

is_fitted = np.isin(shapes.take, ("rest-090_1", "bend-dorsal_1"))
found = calibrate(design, shapes, is_fitted, Settings(weighing=Weighing(mass=mass, spread=spread)))

for parameter in found.parameters[17:]:
    told = "" if parameter.is_identified else ", not told"
    print(
        f"{parameter.name}: {parameter.value:.4g} {parameter.unit}, {parameter.low:.4g} to {parameter.high:.4g}{told}"
    )
for words in advise(found, was_weighed=True):
    print(words)
after, before = (1e3 * np.mean(rmse) for rmse in (found.held_out.calibrated, found.held_out.reference))
print(f"held-out mean RMSE: {after:.2f} mm calibrated, {before:.2f} mm by the paper's model of the design")
assert after < 2.5 < before
assert abs(found.design.cable.friction - 0.2) < 0.02
