"""Summary of a survey's rows: success rates, and failures by reason, cause and class of objects."""

from __future__ import annotations

import re
import statistics
from collections import Counter
from collections.abc import Iterable, Sequence
from typing import Any

from spiraltrunk.sim.objects.catalogue import CATALOGUE
from spiraltrunk.workflows.grasp.verdict.cause import Cause
from spiraltrunk.workflows.survey.plan import SurveyPlan

WIDTHS = (0.025, 0.045, 0.080, 0.120)
"""Widths at which a class of objects ends and the next begins [m] (ours): fingers take up to 45 mm, small loops 80."""

_NUMBER = re.compile(r"(?<![\w.-])-?(?:\d+(?:\.\d+)?(?:e[+-]?\d+)?|nan|inf)(?![\w])", flags=re.IGNORECASE)


def summarize(plan: SurveyPlan, rows: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Success rates by strategy and by object, and whether all trials have ended; ready for JSON."""
    strategies: dict[str, dict[str, Any]] = {}
    for name, objects in plan.objects.items():
        own = [row for row in rows if row["strategy"] == name]
        by_object = {each: count_rate([row for row in own if row["object"] == each]) for each in dict.fromkeys(objects)}
        strategies[name] = {
            **count_rate(own),
            "failures": count_failures(own),
            "causes": count_causes(own),
            "held": _count_claims(own, "held"),
            "upright": _count_claims(own, "upright"),
            "median_wall_s": _median(row["wall_s"] for row in own),
            "median_planning_wall_s": _median(row["planning_wall_s"] for row in own),
            "median_simulated_s": _median(row["simulated_s"] for row in own),
            "median_success_s": _median(row["simulated_s"] for row in own if row["success"]),
            "median_success_first_s": _median(
                row["simulated_s"] for row in own if row["success"] and not row["retries"]
            ),
            "retried": sum(bool(row["retries"]) for row in own),
            "objects": by_object,
        }
    asked = sum(plan.count_trials().values())
    by_class: dict[str, list[dict[str, Any]]] = {name: [] for name in sorted({find_class(row) for row in rows})}
    for row in rows:
        by_class[find_class(row)].append(row)
    classes = {name: {**count_rate(own), "causes": count_causes(own)} for name, own in by_class.items()}
    return {"strategies": strategies, "classes": classes, "complete": len(rows) == asked, "asked": asked}


def count_rate(rows: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Trials, successes, success rate (null without trials), and its 95 % interval."""
    trials, successes = len(rows), sum(row["success"] for row in rows)
    low, high = wilson(successes, trials)
    rate = successes / trials if trials else None
    return {"trials": trials, "successes": successes, "rate": rate, "low": low, "high": high}


def count_failures(rows: Iterable[dict[str, Any]]) -> dict[str, int]:
    """Number of failures by kind of reason, the most frequent first."""
    counted = Counter(find_kind(row["reason"]) for row in rows if not row["success"])
    return dict(sorted(counted.items(), key=lambda pair: (-pair[1], pair[0])))


def count_causes(rows: Iterable[dict[str, Any]]) -> dict[str, int]:
    """Number of failures by cause, in the order of `Cause`."""
    counted = Counter(row["cause"] for row in rows if not row["success"])
    return {cause.value: counted[cause.value] for cause in Cause if counted[cause.value]}


def find_class(row: dict[str, Any]) -> str:
    """Kind and class of width of a trial's object, such as "cylinder, 45 to 80 mm"; the kind alone without a width."""
    kind, width = CATALOGUE.get(row["object"].partition(",")[0], row["object"]).partition(":")[0], row["width_m"]
    if width is None:
        return kind
    above = next((i for i, edge in enumerate(WIDTHS) if width < edge), len(WIDTHS))
    low, high = (f"{1e3 * edge:g}" for edge in ((0.0, *WIDTHS)[above], (*WIDTHS, 0.0)[above]))
    return f"{kind}, {low} mm or more" if above == len(WIDTHS) else f"{kind}, {low} to {high} mm"


def find_kind(reason: str) -> str:
    """The reason with N for its numbers: "lifted 3 cm" and "lifted 5 cm" both give "lifted N cm"."""
    return _NUMBER.sub("N", reason)


def _count_claims(rows: Sequence[dict[str, Any]], name: str) -> int | None:
    """Number of trials that fulfil a claim; None where it applies to none of them, as holding to a kick."""
    claims = [row[name] for row in rows if row[name] is not None]
    return sum(claims) if claims or not rows else None


def _median(values: Iterable[float | None]) -> float | None:
    known = [value for value in values if value is not None]
    return statistics.median(known) if known else None


def wilson(successes: int, trials: int) -> tuple[float, float]:
    """Wilson interval of 95 % for a success rate [-]; 0 to 1 without trials."""
    from scipy.stats import binomtest

    if not trials:
        return 0.0, 1.0
    low, high = binomtest(successes, trials).proportion_ci(0.95, method="wilson")
    return float(low), float(high)
