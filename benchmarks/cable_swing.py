"""How near each trunk of validation/robustness.md is to the integrator's bound of stability, by the time step.

python benchmarks/cable_swing.py
"""

from __future__ import annotations

import math

from spiraltrunk.design import presets
from spiraltrunk.design.rules import design_from_rules
from spiraltrunk.sim.robot.cable_swing import compute_cable_swing

TRUNKS = {
    **{name: presets.get(name) for name in ("paper", "spirob-15", "spirob-1m")},
    "30 deg, by rules": design_from_rules(),
    "m 1.45": design_from_rules(m=1.45),
    "m 1.7": design_from_rules(m=1.7),
    "arm radius 36 mm": design_from_rules(arm_radius=0.036),
    "arm radius 55 mm": design_from_rules(arm_radius=0.055),
    "sections of 20 deg": design_from_rules(delta_theta=math.radians(20.0)),
    "sections of 15 deg": design_from_rules(delta_theta=math.radians(15.0)),
    "sections of 45 deg": design_from_rules(delta_theta=math.radians(45.0)),
}
STEPS = (0.5e-3, 1e-3, 2e-3)
"""Time steps [s]."""


def main() -> None:
    """Print the product of step and angular frequency; it is stable below 2."""
    print(f"{'trunk':20}" + "".join(f"{1e3 * step:8.1f} ms" for step in STEPS))
    for name, design in TRUNKS.items():
        print(f"{name:20}" + "".join(f"{compute_cable_swing(design, step):11.2f}" for step in STEPS))


if __name__ == "__main__":
    main()
