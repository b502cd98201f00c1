"""Two more trunks on the objects that a search has not seen: with large fingers, and the best of a search before.

Is it the fingers? The preset paper-large-grip beside the best trunk. Does a search before hold in other worlds? Its
best trunk beside the preset paper.

`spiraltrunk optimize --out FOLDER ...` searches. `python docs/studies/study_search_fingers.py FOLDER` runs the trials,
in the folder's worlds, and writes search_fingers.json; `make_search.py` puts it into the page.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from dataclasses import fields
from functools import partial
from pathlib import Path
from typing import Any

from spiraltrunk.design import presets
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.files.atomic import write_text
from spiraltrunk.files.results import format_json
from spiraltrunk.workflows.optimize.objective import find_unseen, plan_trials
from spiraltrunk.workflows.optimize.search_space import build_candidate
from spiraltrunk.workflows.optimize.settings import SearchSettings
from spiraltrunk.workflows.survey.compare.compare_surveys import compare_surveys
from spiraltrunk.workflows.survey.run_survey import run_survey

RESULT = Path(__file__).parent / "search_fingers.json"

KEPT = ("trials", "successes", "rate", "low", "high", "causes")
"""What is kept of a survey's counts."""

FORMER = {
    "m": 1.687115789234916, "sections_per_turn": 12.0, "joint_radius_factor": 1.1731206289842744,
    "hole_fraction": 0.6971905474557951, "finger_scale": 1.8513382166023198,
}  # fmt: skip
"""The best trunk of a search with seed 0 by an earlier version: it took 43 of 60 unseen objects, the paper's 33."""

PAIRED = ("difference", "low", "high", "p", "only_a", "only_b")
"""What is kept of a paired comparison of two trunks; the difference is b's rate minus a's."""


def main(folders: Sequence[str]) -> int:
    """Run what is missing, compare and write."""
    if len(folders) != 1:
        print("study_search_fingers: allowed: one folder, of spiraltrunk optimize", file=sys.stderr)
        return 2
    folder = Path(folders[0])
    told = json.loads((folder / "optimize.json").read_text())
    known = {each.name for each in fields(SearchSettings)}
    settings = SearchSettings(
        **{key: value for key, value in told["settings"].items() if key in known},
        unseen=told["unseen"]["paper"]["trials"],
    )
    compare, best = partial(compare_trunks, folder, settings), f"candidate-{told['best']}"
    fingers, former = presets.get("paper-large-grip"), build_candidate(FORMER, name="former")
    result = {
        "design": fingers.name, **try_trunk(folder, settings, fingers), "best": compare(fingers.name, best),
        "paper": compare("paper", fingers.name),
        "former": try_trunk(folder, settings, former) | {"paper": compare("paper", former.name)},
    }  # fmt: skip
    write_text(RESULT, format_json(result) + "\n")
    return 0


def try_trunk(folder: Path, settings: SearchSettings, design: TrunkDesign) -> dict[str, Any]:
    """Counts of a trunk with the objects that the search has not seen."""
    plan = plan_trials(settings, design, are_unseen=True)
    counted = run_survey(plan, folder=find_unseen(folder, settings, design.name))["strategies"][settings.strategy]
    return {key: counted[key] for key in KEPT}


def compare_trunks(folder: Path, settings: SearchSettings, a: str, b: str) -> dict[str, Any]:
    """Two trunks with the same objects in the same worlds."""
    paired = compare_surveys(*(find_unseen(folder, settings, name) for name in (a, b)))["overall"]
    return {key: paired[key] for key in PAIRED}


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
