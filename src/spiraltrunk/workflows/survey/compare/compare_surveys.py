"""Comparison of two surveys, paired by strategy, seed and object: the same worlds with another setting."""

from __future__ import annotations

import statistics
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from spiraltrunk.workflows.survey.compare.paired import Pairs, compute_difference, compute_mcnemar, correct_by_holm
from spiraltrunk.workflows.survey.row import Row
from spiraltrunk.workflows.survey.stored_survey import StoredSurvey, load_survey
from spiraltrunk.workflows.survey.summary import count_rate

LEVEL = 0.05
"""Level of the tests [-]."""

FIGURES = ("lift_m", "hold_s", "place_error_m", "simulated_s", "retries")
"""Figures of the verdict that are compared over the pairs that both succeeded."""

_Pair = tuple[Row, Row]


def compare_surveys(a: str | Path, b: str | Path) -> dict[str, Any]:
    """Compare the success rates of two surveys over the trials that both have; ready for JSON.

    A trial has its twin where strategy, seed and object are equal. Each strategy has an exact McNemar test, corrected
    by Holm over the strategies; the test over all strategies stands alone.

    Raises:
        SurveyError: where a folder holds no survey.
    """
    surveys = [load_survey(folder, "--compare") for folder in (a, b)]
    first, second = ({(row["strategy"], row["seed"], row["object"]): row for row in each.rows} for each in surveys)
    names = list(dict.fromkeys(name for each in surveys for name in each.settings["objects"]))
    shared = [(row, second[key]) for key, row in first.items() if key in second]
    by_strategy = {name: [pair for pair in shared if pair[0]["strategy"] == name] for name in names}
    strategies = {name: _compare(pairs) for name, pairs in by_strategy.items()}
    tested = [name for name, told in strategies.items() if told["pairs"]]
    corrected = correct_by_holm([strategies[name]["p"] for name in tested])
    for told in strategies.values():
        told |= {"p_holm": None, "significant": False}
    for name, probability in zip(tested, corrected, strict=True):
        strategies[name] |= {"p_holm": probability, "significant": probability < LEVEL}
    overall = _compare(shared)
    return {
        "a": str(a),
        "b": str(b),
        "settings": _find_differing(*surveys),
        "strategies": strategies,
        "overall": overall | {"significant": overall["p"] < LEVEL},
        "unpaired": {"a": len(first) - len(shared), "b": len(second) - len(shared)},
    }


def _compare(pairs: Sequence[_Pair]) -> dict[str, Any]:
    """Rates of both, their difference, its test, and the figures of the pairs."""
    outcomes = [(bool(a["success"]), bool(b["success"])) for a, b in pairs]
    counted = Pairs(
        both=outcomes.count((True, True)), only_a=outcomes.count((True, False)), only_b=outcomes.count((False, True)),
        neither=outcomes.count((False, False)),
    )  # fmt: skip
    difference, low, high = compute_difference(counted)
    succeeded = [pair for pair, outcome in zip(pairs, outcomes, strict=True) if all(outcome)]
    return {
        "pairs": counted.count,
        "a": count_rate([a for a, _ in pairs]),
        "b": count_rate([b for _, b in pairs]),
        "only_a": counted.only_a,
        "only_b": counted.only_b,
        "difference": difference if pairs else None,
        "low": low,
        "high": high,
        "p": compute_mcnemar(counted),
        "speed_ratio": _compute_speed_ratio(pairs),
        "figures": {key: _compare_figure(succeeded, key) for key in FIGURES},
    }


def _compare_figure(pairs: Sequence[_Pair], key: str) -> dict[str, float | None]:
    """Medians of a figure, and the mean of its differences with a 95 % interval by Student's t."""
    from scipy.stats import t

    known = [(a[key], b[key]) for a, b in pairs if a[key] is not None and b[key] is not None]
    if not known:
        return dict.fromkeys(("median_a", "median_b", "difference", "low", "high"))
    differences = [b - a for a, b in known]
    mean, half = statistics.fmean(differences), None
    if len(known) > 1:
        half = float(t.ppf(0.975, len(known) - 1)) * statistics.stdev(differences) / len(known) ** 0.5
    median_a, median_b = (statistics.median(values) for values in zip(*known, strict=True))
    low, high = (None, None) if half is None else (mean - half, mean + half)
    return {"median_a": median_a, "median_b": median_b, "difference": mean, "low": low, "high": high}


def _compute_speed_ratio(pairs: Sequence[_Pair]) -> float | None:
    """Median over the pairs of the real-time factor of the second over that of the first [-]."""
    speeds = [(a["real_time_factor"], b["real_time_factor"]) for a, b in pairs]
    known = [b / a for a, b in speeds if a and b]
    return statistics.median(known) if known else None


def _find_differing(first: StoredSurvey, second: StoredSurvey) -> dict[str, Any]:
    """Values of each setting that differs; of a design, the lines that differ."""
    a, b = first.settings, second.settings
    differing: dict[str, list[Any]] = {
        key: [a.get(key), b.get(key)] for key in dict.fromkeys((*a, *b)) if a.get(key) != b.get(key)
    }
    if "design" in differing:
        differing["design"] = _find_differing_lines(a, b)
    return differing


def _find_differing_lines(a: Mapping[str, Any], b: Mapping[str, Any]) -> list[str]:
    one, other = (each["design"].splitlines() for each in (a, b))
    return ["; ".join(line for line in own if line not in theirs) for own, theirs in ((one, other), (other, one))]
