"""Ranks the strategies for the things of study_everyday.py as they are announced: everyday_ranking.json, in a minute.

Nothing moves, so that it tells of all things what the models say, whatever was tried.
"""

from __future__ import annotations

import json
import sys
from dataclasses import asdict, replace
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

from everyday_rules import standing_scene
from study_everyday import GROUNDS, THINGS, load_thing

from spiraltrunk.design import presets
from spiraltrunk.files.atomic import write_text
from spiraltrunk.sim.plant import SimPlant
from spiraltrunk.sim.robot.arm_ik import ArmReach
from spiraltrunk.sim.scene.build import build_task
from spiraltrunk.sim.sensors import SensorOptions
from spiraltrunk.strategies.push.sweep import with_task
from spiraltrunk.workflows.grasp.choice.auto import get_strategy
from spiraltrunk.workflows.grasp.choice.candidates import rank
from spiraltrunk.workflows.grasp.world import Spread, draw_scene

RESULT = Path(__file__).parent / "everyday_ranking.json"

AS_ANNOUNCED = Spread(position=0.0, yaw=0.0, size=0.0, mass=0.0, friction=(0.8, 0.8), sensors=SensorOptions())


def main() -> int:
    """Rank all of them for each design."""
    ranked: dict[str, dict[str, object]] = {}
    for name, ground in GROUNDS.items():
        design = presets.get(name)
        observation, reach = SimPlant(design, standing_scene()).reset(), ArmReach(design)
        ranked[name] = {}
        for thing in THINGS:
            shape = load_thing(thing)
            scene = draw_scene(shape, 0, strategy=get_strategy("auto", design, shape, "ground"), spread=AS_ANNOUNCED)
            task = build_task(design, replace(scene, ground=ground))
            found = rank(with_task(observation, task), reach)
            ranked[name][thing.name] = [asdict(each) for each in found]
    write_text(RESULT, json.dumps(ranked, indent=1) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
