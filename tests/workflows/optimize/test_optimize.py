"""The search with fake trials: the same result interrupted or not, better than its first candidate, nothing lost."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

import pytest

from spiraltrunk.design import load_design, presets
from spiraltrunk.errors import DesignError, OutputError, UnknownName
from spiraltrunk.processes.pool import Outcome
from spiraltrunk.sim.objects.catalogue import parse_object
from spiraltrunk.workflows.optimize import SPACE, SearchSettings, build_candidate, objective, run_search
from spiraltrunk.workflows.optimize.objective import Evaluation, choose_best, evaluate, find_front, plan_trials
from spiraltrunk.workflows.optimize.sampler import Sampler
from spiraltrunk.workflows.optimize.tables import format_markdown
from spiraltrunk.workflows.survey.plan import SurveyPlan
from spiraltrunk.workflows.survey.row import build_empty_row
from spiraltrunk.workflows.survey.summary import count_rate

pytest.importorskip("optuna", reason="the search needs the extra optimize")

FIRST = {each.name: each.first for each in SPACE}
SETTINGS = SearchSettings(candidates=6, objects=10, unseen=10)


class Fake:
    """Trials whose success grows with the joints' stiffness; interrupts the search before a given survey."""

    def __init__(self, stop_at: int | None = None) -> None:
        self.plans: list[SurveyPlan] = []
        self.stop_at = stop_at

    def run(self, plan: SurveyPlan, folder: Path) -> Mapping[str, Any]:
        if len(self.plans) == self.stop_at:
            raise KeyboardInterrupt
        self.plans.append(plan)
        share = min(1.0, plan.design.joint.radius / 0.0048)
        rows = [{"success": i < share * plan.trials} for i in range(plan.trials)]
        return {"strategies": {name: {**count_rate(rows), "causes": {}} for name in plan.objects}}

    def compare(self, a: Path, b: Path) -> Mapping[str, Any]:
        assert (a.name, b.name[:10], a.parent) == ("paper", "candidate-", b.parent)
        return {"overall": {"difference": 0.1, "low": -0.1, "high": 0.3, "p": 0.5, "only_a": 1, "only_b": 2}}


@pytest.fixture(autouse=True)
def printable(monkeypatch: pytest.MonkeyPatch) -> None:
    """Definitions of all parts take a second a candidate."""
    monkeypatch.setattr(objective, "find_faults", lambda design: ())


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Mapping[str, Any]:
    """A search that nothing interrupted."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(objective, "find_faults", lambda design: ())
        return run_search(SETTINGS, tmp_path_factory.mktemp("search") / "whole", trials=Fake())


def read(folder: Path) -> dict[str, Any]:
    return json.loads((folder / "optimize.json").read_text())


def test_the_first_candidate_has_the_authors_proportions(tmp_path: Path) -> None:
    fake = Fake()
    run_search(replace(SETTINGS, candidates=1, unseen=0), tmp_path, trials=fake)
    design = fake.plans[0].design
    assert design.spiral.b == pytest.approx(presets.PAPER.spiral.b, rel=2e-3)
    assert (design.n_section, design.cable.hole_fraction) == (18, 0.6)
    assert design.joint.radius == pytest.approx(presets.PAPER.joint.radius, rel=2e-3)
    assert design.gripper.finger_length == pytest.approx(presets.PAPER.gripper.finger_length, rel=2e-3)


def test_it_finds_what_is_better_and_says_so(tmp_path: Path) -> None:
    result = run_search(replace(SETTINGS, candidates=30), tmp_path, trials=Fake())
    best, first = result["candidates"][result["best"]], result["candidates"][0]
    assert best["success"] > first["success"] + 0.05
    assert result["unseen"]["best"]["successes"] > result["unseen"]["paper"]["successes"]
    design = load_design(tmp_path / "best.toml")
    assert design.joint.radius == pytest.approx(build_candidate(best["values"]).joint.radius)
    assert {path.name for path in tmp_path.glob("[!.]*")} >= set(result["files"])
    assert result["complete"]
    assert read(tmp_path) == result


@pytest.mark.parametrize("stop_at", [5, *(pytest.param(one, marks=pytest.mark.slow) for one in (0, 3, 7))])
def test_an_interrupted_search_goes_on_as_if_it_had_not_been(
    whole: Mapping[str, Any], tmp_path: Path, stop_at: int
) -> None:
    with pytest.raises(KeyboardInterrupt):
        run_search(SETTINGS, tmp_path / "cut", trials=Fake(stop_at))
    assert len(read(tmp_path / "cut")["candidates"]) == min(stop_at, 6) if stop_at else True
    assert run_search(SETTINGS, tmp_path / "cut", trials=Fake()) == whole


def test_more_candidates_go_on_with_the_same_search(whole: Mapping[str, Any], tmp_path: Path) -> None:
    run_search(replace(SETTINGS, candidates=3), tmp_path / "more", trials=Fake())
    more = run_search(SETTINGS, tmp_path / "more", trials=Fake())
    assert more == whole


def run_without_physics(work: Callable[[Any], Any], jobs: Iterable[Any], workers: int) -> Iterator[Outcome[Any, Any]]:
    """An engine whose trials fail, but for candidate 1."""
    name = cast("Any", work).work.keywords["design"].name
    for job in jobs:
        row = build_empty_row(job)
        yield Outcome(job=job, result=row | {"success": True, "cause": None} if name == "candidate-1" else row)


def test_more_candidates_and_other_unseen_objects_go_on_in_the_same_folders(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for module in ("survey.results", "optimize.optimize"):  # Plots take most of the time.
        name = f"spiraltrunk.workflows.{module}.write_figure"
        monkeypatch.setattr(name, lambda figure, path: path.write_bytes(b"a plot"))
    few = SearchSettings(candidates=1, objects=1, unseen=1)
    assert run_search(few, tmp_path, engine=run_without_physics)["best"] == 0
    more = run_search(replace(few, candidates=2), tmp_path, engine=run_without_physics)
    assert (more["best"], more["unseen"]["best"]["successes"], more["unseen"]["difference"]["only_b"]) == (1, 1, 1)
    most = run_search(replace(few, candidates=2, unseen=2), tmp_path, engine=run_without_physics)
    assert (most["unseen"]["best"]["successes"], most["unseen"]["paper"]["trials"]) == (2, 2)
    again = run_search(replace(few, candidates=2), tmp_path, engine=run_without_physics)
    assert again == more


@pytest.mark.slow
def test_what_cannot_be_printed_is_not_simulated_and_not_the_best(tmp_path: Path, monkeypatch) -> None:
    monkeypatch.setattr(objective, "find_faults", lambda design: ("wall too thin",) if design.n_section > 18 else ())
    fake = Fake()
    result = run_search(replace(SETTINGS, candidates=20, unseen=0), tmp_path, trials=fake)
    refused = [each for each in result["candidates"] if each["faults"]]
    assert refused
    assert all(each["trials"] == 0 for each in refused)
    assert all(plan.design.n_section <= 18 for plan in fake.plans)
    assert not result["candidates"][result["best"]]["faults"]
    assert not {each["number"] for each in refused} & set(result["front"])


def test_every_design_meets_the_same_worlds_and_unseen_ones_are_others() -> None:
    one = plan_trials(SETTINGS, presets.PAPER)
    other = plan_trials(SETTINGS, build_candidate(FIRST))
    unseen = plan_trials(SETTINGS, presets.PAPER, are_unseen=True)
    assert one.entries() == other.entries()
    seen = {(entry.object, entry.seed) for entry in one.entries()}
    assert len(seen) == 10
    assert not {entry.object for entry in one.entries()} & {entry.object for entry in unseen.entries()}
    assert not {entry.seed for entry in one.entries()} & {entry.seed for entry in unseen.entries()}
    assert parse_object(one.entries()[0].object).mass > 0.0


def test_values_that_give_no_trunk_are_a_fault(tmp_path: Path) -> None:
    judged = evaluate(3, {**FIRST, "joint_radius_factor": 9.0}, SETTINGS, tmp_path, Fake().run)
    assert judged.faults == ("joint_radius_factor is 9.0; allowed: a finite number, at least 0.8, at most 1.25",)


@pytest.mark.parametrize(
    "values", [{}, {**FIRST, "m": 0.5}, {**FIRST, "finger_scale": float("nan")}, {**FIRST, "x": 1}]
)
def test_points_outside_the_space_are_refused(values: dict[str, float]) -> None:
    with pytest.raises(DesignError):
        build_candidate(values)


def make(number: int, successes: int, payload: float, span: float, faults: tuple[str, ...] = ()) -> Evaluation:
    return Evaluation(
        number=number,
        values=FIRST,
        trials=10,
        successes=successes,
        payload=payload,
        range=span,
        faults=faults,
        causes={},
    )


def test_the_front_holds_what_nothing_beats() -> None:
    judged = [make(0, 5, 1.0, 0.1), make(1, 6, 1.0, 0.1), make(2, 4, 2.0, 0.1), make(3, 9, 9.0, 9.0, ("thin",))]
    assert [each.number for each in find_front(judged)] == [1, 2]
    assert choose_best(judged).number == 1
    assert choose_best([]) is None


@pytest.mark.parametrize(
    ("change", "line"),
    [
        ({"seed": 1}, "seed 0, not 1"),
        ({"objects": 5}, "objects 10, not 5"),
        ({"friction": 0.1}, "friction 0.0, not 0.1"),
    ],
)
def test_the_folder_of_another_search_is_refused(tmp_path: Path, change: dict[str, Any], line: str) -> None:
    settings = replace(SETTINGS, candidates=1, unseen=0)
    run_search(settings, tmp_path, trials=Fake())
    before = read(tmp_path)
    with pytest.raises(OutputError, match=line):
        run_search(replace(settings, **change), tmp_path, trials=Fake())
    assert read(tmp_path) == before


def test_a_damaged_journal_is_one_line(tmp_path: Path) -> None:
    settings = replace(SETTINGS, candidates=2, unseen=0)
    run_search(settings, tmp_path, trials=Fake())
    (tmp_path / "study.log").write_text('{"op_code": 99}\nnothing\n{}\n')
    with pytest.raises(OutputError, match="is no journal of a search"):
        run_search(settings, tmp_path, trials=Fake())


@pytest.mark.slow
def test_a_journal_whose_last_line_was_cut_off_goes_on(tmp_path: Path) -> None:
    whole = run_search(replace(SETTINGS, unseen=0), tmp_path / "whole", trials=Fake())
    run_search(replace(SETTINGS, candidates=3, unseen=0), tmp_path / "cut", trials=Fake())
    journal = tmp_path / "cut" / "study.log"
    journal.write_bytes(journal.read_bytes()[:-20])
    again = run_search(replace(SETTINGS, unseen=0), tmp_path / "cut", trials=Fake())
    assert again["candidates"] == whole["candidates"]


@pytest.mark.parametrize(
    "change", [{"candidates": 0}, {"objects": 0}, {"friction": -1.0}, {"seed": -1}, {"unseen": -1}]
)
def test_settings_out_of_range_are_refused(change: dict[str, Any]) -> None:
    with pytest.raises(DesignError):
        replace(SETTINGS, **change)


@pytest.mark.parametrize("change", [{"strategy": "wave"}, {"kind": "cloud"}])
def test_unknown_names_are_refused(change: dict[str, Any]) -> None:
    with pytest.raises(UnknownName):
        replace(SETTINGS, **change)


@pytest.mark.parametrize("method", ["ask", "suggest_float", "suggest_int"])
def test_a_kill_while_the_first_candidate_is_drawn_leaves_the_authors_point_to_evaluate(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, method: str
) -> None:
    optuna = pytest.importorskip("optuna")
    with monkeypatch.context() as patch:
        patch.setattr(optuna.Study if method == "ask" else optuna.trial.Trial, method, interrupt)
        with pytest.raises(KeyboardInterrupt):
            Sampler(tmp_path / "study.log", 0).ask()
    points = []
    for _ in range(3):
        sampler = Sampler(tmp_path / "study.log", 0)
        number, values = sampler.ask()
        sampler.tell(make(number, 1, 1.0, 0.1))
        points.append(values)
    assert points[0] == pytest.approx(FIRST)
    assert FIRST not in points[1:]


def interrupt(*_: object, **__: object) -> None:
    raise KeyboardInterrupt


@pytest.mark.slow
def test_a_real_search_of_one_candidate(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.undo()
    settings = SearchSettings(candidates=1, objects=2, unseen=1, strategy="wrap-vertical", kind="cylinder")
    result = run_search(settings, tmp_path)
    assert result["candidates"][0]["trials"] == 2
    assert (tmp_path / "candidates" / "0000" / "trials.jsonl").exists()
    assert set(result["unseen"]) == {"paper", "best", "difference"}


def test_a_trunk_that_was_not_tried_has_dashes_and_no_rate() -> None:
    values = {each.name: 1.0 for each in SPACE}
    made = {"number": 0, "values": values, "faults": [], "successes": 3, "trials": 4, "success": 0.75, "low": 0.3,
            "high": 0.95, "payload": 4.0, "range": 0.2}  # fmt: skip
    unmade = made | {
        "number": 1,
        "faults": ["too thin"],
        "successes": 0,
        "trials": 0,
        "success": 0.0,
        "low": 0.0,
        "high": 1.0,
    }
    rows = format_markdown(
        {"candidates": [made, unmade], "best": 0, "front": [0], "complete": True, "unseen": None}
    ).splitlines()
    assert "| 3 of 4 | 30 to 95 % |" in rows[2]
    assert "| - | - | 4.00 | 200 | cannot be made: too thin |" in rows[3]
