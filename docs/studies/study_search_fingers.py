"""Is it the fingers? The preset paper-large-grip on the objects that a search has not seen, beside its best trunk.

`spiraltrunk optimize --out FOLDER ...` searches. `python docs/studies/study_search_fingers.py FOLDER` runs the trials,
in the folder's worlds, and writes search_fingers.json; `make_search.py` puts it into the page.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from dataclasses import fields
from pathlib import Path

from spiraltrunk.design import presets
from spiraltrunk.files.atomic import write_text
from spiraltrunk.files.results import format_json
from spiraltrunk.workflows.optimize.objective import plan_trials
from spiraltrunk.workflows.optimize.settings import SearchSettings
from spiraltrunk.workflows.survey.compare.compare_surveys import compare_surveys
from spiraltrunk.workflows.survey.run_survey import run_survey

RESULT = Path(__file__).parent / "search_fingers.json"

KEPT = ("trials", "successes", "rate", "low", "high", "causes")
"""What is kept of a survey's counts."""

PAIRED = ("difference", "low", "high", "p", "only_a", "only_b")
"""What is kept of a paired comparison; a is the preset, b the best trunk of the search."""


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
    design = presets.get("paper-large-grip")
    plan = plan_trials(settings, design, are_unseen=True)
    counted = run_survey(plan, folder=folder / "unseen" / design.name)["strategies"][settings.strategy]
    paired = compare_surveys(folder / "unseen" / design.name, folder / "unseen" / "best")["overall"]
    result = {
        "design": design.name, **{key: counted[key] for key in KEPT}, "best": {key: paired[key] for key in PAIRED}
    }  # fmt: skip
    write_text(RESULT, format_json(result) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
