"""Rates, kinds of failures and the tables of them."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from spiraltrunk.workflows.survey.plan import SurveyPlan
from spiraltrunk.workflows.survey.row import build_empty_row, fill_row
from spiraltrunk.workflows.survey.summary import count_failures, find_class, find_kind, summarize
from spiraltrunk.workflows.survey.tables import format_markdown, format_text

KINDS = {
    "lifted 3 cm": "lifted N cm",
    "lifted -3 cm": "lifted N cm",
    "held alone for 0.4 s": "held alone for N s",
    "released nan cm from the target": "released N cm from the target",
    "error 1.5e-07 at [0.1 -2. 3]": "error N at [N N. N]",
    "cylinder-60 is lost": "cylinder-60 is lost",
    "its process died (SIGKILL)": "its process died (SIGKILL)",
    "the object touched housing or arm": "the object touched housing or arm",
}


@pytest.fixture
def rows(plan: SurveyPlan) -> list[dict[str, Any]]:
    """All but the last trial; wrap-vertical fails at its first two, kick at none."""
    rows = [build_empty_row(entry, "lifted 3 cm") for entry in plan.entries()[:-1]]
    for i, row in enumerate(rows):
        row |= {"wall_s": float(i), "simulated_s": 30.0 + i, "width_m": 0.06, "cause": "slipped"}
        row["retries"] = 1 if row["strategy"] == "kick" or i == 8 else 0
        if row["strategy"] == "kick" or row["index"] > 1:
            row |= {"success": True, "reason": "success", "cause": None, "held": True, "upright": i % 4 == 0}
    rows[2] |= {"reason": "lifted 12 cm", "cause": "missed", "width_m": 0.1}
    return rows


@pytest.mark.parametrize("reason", KINDS)
def test_kinds_of_reasons(reason: str) -> None:
    assert find_kind(reason) == KINDS[reason]


@given(st.floats(), st.floats())
def test_reasons_that_differ_in_a_number_are_of_one_kind(one: float, other: float) -> None:
    assert len({find_kind(f"lifted {value} cm") for value in (one, other)}) == 1


def test_failures_come_most_frequent_first() -> None:
    reasons = ("b 1", "a 1", "b 2", "c", "success")
    counted = count_failures({"success": reason == "success", "reason": reason} for reason in reasons)
    assert list(counted.items()) == [("b N", 2), ("a N", 1), ("c", 1)]


def test_summary_counts_strategies_and_objects(plan: SurveyPlan, rows: list[dict[str, Any]]) -> None:
    summary = summarize(plan, rows)
    wrap, kick = summary["strategies"]["wrap-vertical"], summary["strategies"]["kick"]
    assert (wrap["trials"], wrap["successes"], wrap["rate"]) == (5, 3, 0.6)
    assert wrap["failures"] == {"lifted N cm": 2}
    assert [(name, part["successes"], part["trials"]) for name, part in wrap["objects"].items()] == [
        ("cylinder-60", 2, 3),
        ("ball-80", 1, 2),
    ]
    assert (kick["trials"], kick["rate"], kick["failures"]) == (4, 1.0, {})
    assert list(wrap["causes"].items()) == [("missed", 1), ("slipped", 1)]
    assert (wrap["held"], wrap["upright"], kick["causes"]) == (3, 2, {})
    assert (wrap["median_wall_s"], wrap["median_simulated_s"], kick["retried"]) == (4.0, 34.0, 4)
    assert (wrap["median_success_s"], wrap["median_success_first_s"]) == (36.0, 35.0)
    assert (kick["median_success_s"], kick["median_success_first_s"]) == (34.0, None)
    assert (summary["complete"], summary["asked"]) == (False, 10)


def test_summary_counts_failures_by_class_of_objects(plan: SurveyPlan, rows: list[dict[str, Any]]) -> None:
    classes = summarize(plan, rows)["classes"]
    assert {name: (own["successes"], own["trials"], own["causes"]) for name, own in classes.items()} == {
        "box, 45 to 80 mm": (4, 4, {}),
        "cylinder, 45 to 80 mm": (2, 3, {"slipped": 1}),
        "sphere, 45 to 80 mm": (1, 1, {}),
        "sphere, 80 to 120 mm": (0, 1, {"missed": 1}),
    }


@pytest.mark.parametrize(
    ("spec", "width", "told"),
    [
        ("ball-80", 0.02, "sphere, 0 to 25 mm"),
        ("box:x_mm=30,y_mm=30,z_mm=30,mass_g=9", 0.045, "box, 45 to 80 mm"),
        ("stl:path=a.stl,unit=mm,mass_g=9", 0.12, "stl, 120 mm or more"),
        ("ring-90", None, "ring"),
    ],
)
def test_classes_are_kinds_and_widths(spec: str, width: float | None, told: str) -> None:
    assert find_class({"object": spec, "width_m": width}) == told


def test_a_row_of_an_earlier_version_has_no_cause() -> None:
    assert fill_row({"success": False})["cause"] == "unknown"
    assert fill_row({"success": True})["cause"] is None
    assert fill_row({"success": False, "cause": "missed"}) == {
        "success": False, "cause": "missed", "cause_time_s": None, "held": None, "upright": None,
    }  # fmt: skip


def test_summary_of_nothing_claims_nothing(plan: SurveyPlan) -> None:
    told = summarize(plan, [])["strategies"]["kick"]
    assert (told["rate"], told["low"], told["high"], told["median_wall_s"]) == (None, 0.0, 1.0, None)


def test_what_a_kick_does_not_claim_is_a_dash(plan: SurveyPlan, rows: list[dict[str, Any]]) -> None:
    for row in rows:
        if row["strategy"] == "kick":
            row["held"] = row["upright"] = None
    summary = summarize(plan, rows)
    assert summary["strategies"]["kick"]["held"] is None
    assert "| `kick` | 4 of 4 | 100 % | 51.0-100.0 % | - | - |" in format_markdown(summary)


def test_tables(plan: SurveyPlan, rows: list[dict[str, Any]]) -> None:
    summary = summarize(plan, rows)
    assert format_text(summary).splitlines()[2:] == [
        "wrap-vertical  3 of 5     60 %   23.1-88.2 %    4.0        1 x missed; 1 x slipped  2 x lifted N cm",
        "kick           4 of 4     100 %  51.0-100.0 %   4.0        -                        -",
    ]
    page = format_markdown(summary)
    assert page.startswith("Incomplete: 9 of 10 trials.\n\n| strategy |")
    assert (
        "| `wrap-vertical` | 3 of 5 | 60 % | 23.1-88.2 % | 3 | 2 | 36.0 | 35.0 "
        "| 1 x missed; 1 x slipped | 2 x lifted N cm |\n"
    ) in page
    assert "| cylinder, 45 to 80 mm | 2 of 3 | 67 % | 20.8-93.9 % | 1 x slipped |\n" in page
    assert "| `wrap-vertical` | `ball-80` | 1 of 2 | 50 % | 9.5-90.5 % |\n" in page
    assert format_markdown({**summary, "complete": True}).startswith("| strategy |")


def test_a_survey_of_an_earlier_version_has_a_table(plan: SurveyPlan, rows: list[dict[str, Any]]) -> None:
    """Without causes, classes and times of the successful trials."""
    summary = summarize(plan, rows)
    for own in summary["strategies"].values():
        for key in ("causes", "held", "upright", "median_success_s", "median_success_first_s"):
            del own[key]
    del summary["classes"]
    page = format_markdown(summary)
    assert "| `wrap-vertical` | 3 of 5 | 60 % | 23.1-88.2 % | - | - | - | - | - | 2 x lifted N cm |\n" in page
    assert "class of objects" not in page
    assert "2 x lifted N cm" in format_text(summary)
