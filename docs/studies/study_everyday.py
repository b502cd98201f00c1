"""Tries everyday things with the strategy that the program chooses: figures of validation/everyday.md.

Each thing is put on the ground, `auto` ranks the strategies and takes the best, with each of two designs and each seed.
Each trial's row is appended to everyday.json as it ends, with a picture of the moment that tells its outcome in
``--out``; a run that was interrupted goes on where it ended. `make_everyday.py` puts both into the page.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import sys
import time
from collections.abc import Iterator
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
if not os.environ.get("MUJOCO_GL") and not os.environ.get("DISPLAY"):
    os.environ["MUJOCO_GL"] = "egl"

sys.path.insert(0, str(Path(__file__).parent))

import trimesh
from make_everyday import name_picture
from PIL import Image

from spiraltrunk.design import presets
from spiraltrunk.errors import SpiralTrunkError
from spiraltrunk.files.atomic import atomic_file, write_text
from spiraltrunk.files.results import to_json
from spiraltrunk.sim.framing import frame_view
from spiraltrunk.sim.ground_truth import Sample
from spiraltrunk.sim.objects.catalogue import ObjectSpec, parse_object
from spiraltrunk.sim.render import View, render_frames
from spiraltrunk.workflows.grasp.choice.auto import get_strategy
from spiraltrunk.workflows.grasp.choice.last_try import list_attempts, list_candidates
from spiraltrunk.workflows.grasp.trial import Trial, run_scene
from spiraltrunk.workflows.grasp.world import draw_scene

STUDIES = Path(__file__).parent
RESULT = STUDIES / "everyday.json"

GROUNDS = {"paper": 0.60, "paper-large-grip": 0.45}
"""Designs, and the height of the ground of their trials [m]: long fingers need the arm higher above the ground, and
`auto` takes the ground as it is."""

SEEDS = (0, 1)
"""Seeds of the worlds; a thing that is refused before anything moves is tried in the first alone."""

PICTURE = View(width=520, height=440, fovy=20.0)
"""Direction and size of the pictures."""


@dataclass(frozen=True, kw_only=True)
class Thing:
    """An everyday thing."""

    name: str
    """What people call it."""
    measures: str
    """Its size as it rests, in mm, and its mass."""
    spec: str
    """As `--object` takes it; an ellipsoid's surface is written to the file of its name."""
    axes_mm: tuple[float, float, float] | None = None
    """Lengths of the three axes of an ellipsoid [mm]."""


THINGS = (
    Thing(name="food can", measures="50 x 80, 150 g", spec="cylinder:diameter_mm=50,height_mm=80,mass_g=150"),
    Thing(name="soup can", measures="66 x 115, 350 g", spec="cylinder:diameter_mm=66,height_mm=115,mass_g=350"),
    Thing(name="bottle", measures="58 x 160, 300 g", spec="bottle:diameter_mm=58,height_mm=160,neck_mm=26,mass_g=300"),
    Thing(name="milk carton", measures="40 x 40 x 144, 250 g", spec="box:x_mm=40,y_mm=40,z_mm=144,mass_g=250"),
    Thing(
        name="lemon", measures="40 x 40 x 68, 100 g", spec="stl:path=lemon.stl,mass_g=100,unit=mm,pose=lying",
        axes_mm=(40.0, 40.0, 68.0),
    ),
    Thing(name="mug, no handle", measures="80 x 95, 300 g", spec="cylinder:diameter_mm=80,height_mm=95,mass_g=300"),
    Thing(name="cereal box", measures="100 x 30 x 150, 150 g", spec="box:x_mm=100,y_mm=30,z_mm=150,mass_g=150"),
    Thing(name="bun", measures="48 x 40 x 48, 60 g", spec="box:x_mm=48,y_mm=40,z_mm=48,mass_g=60"),
    Thing(name="orange", measures="70, 150 g", spec="sphere:diameter_mm=70,mass_g=150"),
    Thing(name="milk carton, lying", measures="144 x 40 x 40, 250 g", spec="box:x_mm=144,y_mm=40,z_mm=40,mass_g=250"),
    Thing(
        name="bottle, lying", measures="160 x 58, 300 g",
        spec="bottle:diameter_mm=58,height_mm=160,neck_mm=26,mass_g=300,pose=lying",
    ),
    Thing(
        name="egg", measures="45 x 45 x 57, 60 g", spec="stl:path=egg.stl,mass_g=60,unit=mm,pose=lying",
        axes_mm=(45.0, 45.0, 57.0),
    ),
    Thing(name="glass", measures="70 x 130, 280 g", spec="cylinder:diameter_mm=70,height_mm=130,mass_g=280"),
    Thing(
        name="banana, as a rod", measures="180 x 35, 120 g",
        spec="cylinder:diameter_mm=35,height_mm=180,mass_g=120,pose=lying",
    ),
    Thing(name="apple", measures="80, 180 g", spec="sphere:diameter_mm=80,mass_g=180"),
    Thing(name="pen", measures="140 x 12, 15 g", spec="cylinder:diameter_mm=12,height_mm=140,mass_g=15,pose=lying"),
    Thing(name="book, lying", measures="200 x 130 x 25, 400 g", spec="box:x_mm=200,y_mm=130,z_mm=25,mass_g=400"),
    Thing(name="plate", measures="200 x 20, 400 g", spec="cylinder:diameter_mm=200,height_mm=20,mass_g=400"),
    Thing(name="shoe box", measures="330 x 200 x 120, 900 g", spec="box:x_mm=330,y_mm=200,z_mm=120,mass_g=900"),
    Thing(name="iron weight", measures="90 x 120, 5 kg", spec="cylinder:diameter_mm=90,height_mm=120,mass_g=5000"),
)  # fmt: skip
"""Everyday things, those that matter most first."""


def main() -> int:
    """Run what is not there yet."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=Path("out/everyday"), help="folder of the pictures")
    parser.add_argument("--seeds", type=int, nargs="+", default=SEEDS, help="seeds of the worlds")
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    rows = json.loads(RESULT.read_text())["rows"] if RESULT.exists() else []
    for seed, design, thing in list_trials(arguments.seeds):
        done = {(row["seed"], row["design"], row["thing"]): row for row in rows}
        first, here = (done.get((each, design, thing.name)) for each in (arguments.seeds[0], seed))
        if here is not None or (first is not None and first["cause"] == "refused"):
            continue
        began = time.perf_counter()
        rows.append(try_thing(thing, design, seed, arguments.out))
        write_text(RESULT, json.dumps({"things": [asdict(each) for each in THINGS], "rows": rows}, indent=1) + "\n")
        told = rows[-1]["reason"][:100]
        print(f"{design}, {thing.name}, seed {seed}: {told} ({time.perf_counter() - began:.0f} s)", flush=True)
    return 0


def list_trials(seeds: tuple[int, ...]) -> Iterator[tuple[int, str, Thing]]:
    """Seed, design and thing of each trial: all things with the first seed come first."""
    return ((seed, design, thing) for seed in seeds for thing in THINGS for design in GROUNDS)


def load_thing(thing: Thing) -> ObjectSpec:
    """The thing as an object."""
    if thing.axes_mm is None:
        return parse_object(thing.spec)
    name = thing.spec.partition("path=")[2].partition(",")[0]
    with TemporaryDirectory() as folder:
        surface = trimesh.creation.icosphere(subdivisions=3, radius=0.5)
        surface.apply_scale(thing.axes_mm)
        surface.export(Path(folder) / name)
        return parse_object(thing.spec.replace(name, str(Path(folder) / name)))


def try_thing(thing: Thing, design: str, seed: int, out: Path) -> dict[str, Any]:
    """One trial as a row; its picture lies in ``out``."""
    row = {"thing": thing.name, "design": design, "seed": seed, "ground_m": GROUNDS[design]}
    trunk, shape = presets.get(design), load_thing(thing)
    strategy = get_strategy("auto", trunk, shape, "ground")
    try:
        options = replace(draw_scene(shape, seed, strategy=strategy), ground=GROUNDS[design])
        trial = run_scene(trunk, options, strategy=strategy, seed=seed)
    except SpiralTrunkError as error:
        return row | {"success": False, "held": False, "cause": "error", "reason": str(error)}
    draw_trial(trial, out / name_picture(row))
    return row | {key: to_json(value) for key, value in tell(trial).items()}


def tell(trial: Trial) -> dict[str, Any]:
    """What a trial found: the ranking before anything moved, the tries, and the outcome."""
    verdict, attempts = trial.verdict, list_attempts(trial.log)
    return {
        "success": verdict.success,
        "held": verdict.is_held,
        "upright": verdict.is_upright,
        "reason": verdict.reason,
        "cause": None if verdict.failure is None else verdict.failure.cause.value,
        "cause_time_s": None if verdict.failure is None else verdict.failure.time,
        "time_s": trial.plant.trace[-1].time,
        "width_mm": round(1e3 * trial.options.shape.width, 1),
        "mass_g": round(1e3 * trial.options.shape.mass),
        "friction": round(trial.options.shape.friction, 2),
        "candidates": [asdict(each) for each in list_candidates(trial.log) or ()],
        "attempts": [
            {"strategy": each.strategy, "outcome": each.outcome or verdict.reason} for each in attempts
        ],
    }  # fmt: skip


def draw_trial(trial: Trial, path: Path) -> None:
    """The object as it is held, the moment of the failure, or the scene before anything moves."""
    sample, model = find_moment(trial), trial.plant.model
    view = frame_view(model, [sample.qpos], PICTURE)
    frame = next(iter(render_frames(model, [sample.qpos], view)))
    with atomic_file(path) as draft:
        Image.fromarray(frame).save(draft, format="png")


def find_moment(trial: Trial) -> Sample:
    """The middle of the hold of a success, else the failure's moment."""
    trace, failure, span = trial.plant.trace, trial.verdict.failure, trial.log.span("transport", "hold")
    if failure is None:
        at = trace[-1].time if span is None else sum(span) / 2
    else:
        at = failure.time if math.isfinite(failure.time) else trace[-1].time
    return min(trace, key=lambda sample: abs(sample.time - at))


if __name__ == "__main__":
    sys.exit(main())
