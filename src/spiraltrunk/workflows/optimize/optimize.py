"""The search: point by point, each evaluated by a survey in a folder of its own, then the best against the paper's."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any, final

from spiraltrunk.checks import check_count
from spiraltrunk.design import presets
from spiraltrunk.design.toml import format_design
from spiraltrunk.design.trunk import TrunkDesign
from spiraltrunk.errors import OutputError
from spiraltrunk.files.atomic import write_text
from spiraltrunk.files.output_folder import OutputFolder, open_output
from spiraltrunk.files.results import Progress, format_json, ignore_progress, read_versions, to_json
from spiraltrunk.processes.pool import Engine
from spiraltrunk.report.search_plot import CandidatePoint, build_front_figure, build_history_figure
from spiraltrunk.report.style import write_figure
from spiraltrunk.workflows.optimize.objective import (
    OBJECTIVES,
    PAYLOAD_WIDTH,
    Evaluation,
    Trials,
    choose_best,
    evaluate,
    find_front,
    find_unseen,
    plan_trials,
)
from spiraltrunk.workflows.optimize.sampler import Sampler
from spiraltrunk.workflows.optimize.search_space import SPACE, build_candidate
from spiraltrunk.workflows.optimize.settings import SearchSettings
from spiraltrunk.workflows.optimize.tables import format_markdown
from spiraltrunk.workflows.survey.compare.compare_surveys import compare_surveys
from spiraltrunk.workflows.survey.plan import SurveyPlan
from spiraltrunk.workflows.survey.run_survey import MOST_WORKERS, run_survey

WRITER = "optimize"
"""Name of the command in output folders."""

FILES = ("optimize.json", "study.log", "best.toml", "table.md", "history.png", "front.png")
"""Files of a search, besides the surveys in `candidates` and `unseen`."""

_ALLOWED = "allowed: the folder of a search with the same settings, or a new one"


def run_search(
    settings: SearchSettings,
    folder: str | Path | OutputFolder,
    *,
    workers: int = 1,
    engine: Engine | None = None,
    progress: Progress = ignore_progress,
    trials: Trials | None = None,
) -> dict[str, Any]:
    """Evaluate candidates until there are as many as asked for; those that the folder holds are not evaluated again.

    The result depends on the settings alone, not on workers and interruptions.

    Args:
        settings: what is searched.
        folder: where surveys, the journal and the result are kept.
        workers: processes that share the trials of a candidate.
        engine: what runs the trials, as in `run_survey`; None is the pool of this machine.
        progress: called as the work goes on.
        trials: runs and compares surveys in folders; None takes `run_survey` and `compare_surveys`.

    Returns:
        Candidates, the best, the Pareto front and the comparison on unseen objects, ready for JSON.

    Raises:
        DesignError: for a number of workers out of range.
        MissingPackage: where Optuna is not installed.
        OutputError: where the folder cannot be written, or holds something else.
        SurveyError: where a candidate's folder holds another survey.
        RunError: where processes cannot be started.
    """
    check_count("survey.workers", workers, least=1, most=MOST_WORKERS)
    trials = trials or LocalTrials(workers=workers, engine=engine)
    with open_output(folder, WRITER, FILES) as output:
        _check_folder(output, settings)
        sampler = Sampler(output.add_log("study.log"), settings.seed)
        evaluator = _Evaluator(settings, output, trials, progress)
        done = [evaluator.evaluate(number, values) for number, values in sampler.list_evaluated()]
        result = _summarise(settings, done, {})
        try:
            _write(output, result)
            while len(done) < settings.candidates:
                number, values = sampler.ask()
                done.append(evaluator.evaluate(number, values))
                sampler.tell(done[-1])
                result = _summarise(settings, done, {})
                _write(output, result)
            result = _summarise(settings, done, evaluator.compare(choose_best(done)))
        finally:
            _write(output, result)
            _write_pictures(output, done)
    return result


@final
@dataclass(frozen=True, kw_only=True)
class LocalTrials:
    """Surveys in folders of this machine, their trials run by its processes or by an engine."""

    workers: int = 1
    """Processes."""
    engine: Engine | None = None
    """What runs the trials; None is the pool of this machine."""

    def run(self, plan: SurveyPlan, folder: Path) -> Mapping[str, Any]:
        """See `run_survey`."""
        return run_survey(plan, workers=self.workers, folder=folder, engine=self.engine)

    def compare(self, a: Path, b: Path) -> Mapping[str, Any]:
        """See `compare_surveys`."""
        return compare_surveys(a, b)


@final
class _Evaluator:
    """Evaluates candidates in folders of their own."""

    def __init__(self, settings: SearchSettings, output: OutputFolder, trials: Trials, progress: Progress) -> None:
        self._settings, self._output, self._trials, self._progress = settings, output, trials, progress

    def evaluate(self, number: int, values: Mapping[str, float]) -> Evaluation:
        """The candidate's evaluation; trials that were run are read from its folder."""
        self._progress(f"candidate {number}", number, self._settings.candidates)
        folder = self._output.path / "candidates" / f"{number:04d}"
        return evaluate(number, values, self._settings, folder, self._trials.run)

    def compare(self, best: Evaluation | None) -> dict[str, Any]:
        """The best trunk and the preset paper on objects that the search has not seen, in the same worlds."""
        if best is None or not self._settings.unseen:
            return {}
        paper = replace(
            presets.PAPER, cable=replace(presets.PAPER.cable, friction=self._settings.friction), name="paper"
        )
        designs = {"paper": paper, "best": self._build(best)}
        places = {name: find_unseen(self._output.path, self._settings, each.name) for name, each in designs.items()}
        found = {}
        for i, (name, design) in enumerate(designs.items()):
            self._progress(f"unseen objects, {name}", self._settings.candidates + i, self._settings.candidates + 2)
            plan = plan_trials(self._settings, design, are_unseen=True)
            found[name] = self._trials.run(plan, places[name])["strategies"][self._settings.strategy]
        paired = self._trials.compare(places["paper"], places["best"])["overall"]
        keys = ("trials", "successes", "rate", "low", "high", "causes")
        return {
            **{name: {key: counted[key] for key in keys} for name, counted in found.items()},
            "difference": {key: paired[key] for key in ("difference", "low", "high", "p", "only_a", "only_b")},
        }

    def _build(self, best: Evaluation) -> TrunkDesign:
        return build_candidate(best.values, friction=self._settings.friction, name=f"candidate-{best.number}")


def _check_folder(output: OutputFolder, settings: SearchSettings) -> None:
    """Refuse a folder that holds another search.

    Raises:
        OutputError: with the first setting that differs.
    """
    path = output.path / "optimize.json"
    wanted = _describe(settings)
    try:
        held = json.loads(path.read_text())["settings"]
        differing = [key for key in wanted if held[key] != wanted[key]]
    except FileNotFoundError:
        return
    except (ValueError, TypeError, KeyError, RecursionError):
        raise OutputError(f"--out: {str(path)!r} is no search's; {_ALLOWED}") from None
    if differing:
        key = differing[0]
        what = f"a search with {key} {json.dumps(held[key])}, not {json.dumps(wanted[key])}"
        raise OutputError(f"--out: {str(output.path)!r} holds {what}; {_ALLOWED}")


def _describe(settings: SearchSettings) -> dict[str, Any]:
    space = {each.name: [each.least, each.most] for each in SPACE}
    versions = read_versions("mujoco", "optuna")
    del versions["python"]
    return {**settings.describe(), "space": space, "versions": versions}


def _summarise(settings: SearchSettings, done: Sequence[Evaluation], unseen: Mapping[str, Any]) -> dict[str, Any]:
    best = choose_best(done)
    result = {
        "settings": _describe(settings),
        "objectives": list(OBJECTIVES),
        "payload_width_m": PAYLOAD_WIDTH,
        "asked": settings.candidates,
        "complete": len(done) >= settings.candidates,
        "candidates": [{**asdict(each), "success": each.success} for each in done],
        "front": [each.number for each in find_front(done)],
        "best": None if best is None else best.number,
        "unseen": dict(unseen),
        "files": list(FILES if best is not None else (name for name in FILES if name != "best.toml")),
    }
    return dict(to_json(result))


def _write(output: OutputFolder, result: Mapping[str, Any]) -> None:
    """Write the numbers that stand so far, and the best trunk."""
    with output.draft(is_partial=True) as draft:
        if result["best"] is not None:
            values = next(each["values"] for each in result["candidates"] if each["number"] == result["best"])
            friction, name = result["settings"]["friction"], f"candidate-{result['best']}"
            write_text(draft / "best.toml", format_design(build_candidate(values, friction=friction, name=name)))
        write_text(draft / "table.md", format_markdown(result))
        write_text(draft / "optimize.json", format_json(result) + "\n")


def _write_pictures(output: OutputFolder, done: Sequence[Evaluation]) -> None:
    points = [
        CandidatePoint(
            number=each.number, success=each.success, low=each.low, high=each.high, payload=each.payload,
            range=each.range, is_printable=not each.faults,
        )
        for each in done
    ]  # fmt: skip
    front = [each.number for each in find_front(done)]
    with output.draft(is_partial=True) as draft:
        write_figure(build_history_figure(points), draft / "history.png")
        write_figure(build_front_figure(points, front, PAYLOAD_WIDTH), draft / "front.png")
