"""Texts of the tab: what the models predict, how far a run is, and how it ended."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from spiraltrunk.strategies.scores import RATE
from spiraltrunk.studio.page.markdown import escape_markdown
from spiraltrunk.workflows.grasp.choice.auto import AUTO
from spiraltrunk.workflows.grasp.choice.candidates import Candidate
from spiraltrunk.workflows.grasp.recording import Frames

START = "Pick an object and press **Run grasp**. The grasp is simulated and shown as it is computed."

_CHANCE = (
    "Chance: of success at the first try, in simulation; a rate, times a factor for each margin that is small.\n\n"
)

RANKING = "Asking the models which strategy can take the object ..."

NO_OBJECT = "Nothing is asked of the models before there is an object."


def describe_choice(strategy: str, candidates: Sequence[Candidate]) -> str:
    """What the models predict for the picked strategy, in a line or two."""
    able = [each for each in candidates if each.feasible]
    best = f"Best: **{able[0].strategy}**." if able else "No strategy of this stage can take it; try the other stage."
    if strategy == AUTO:
        return f"**auto** tries the best first. {best}" if able else best
    found = next((each for each in candidates if each.strategy == strategy), None)
    if found is None:
        return best
    if found.feasible:
        reason, factors = _split_reason(found)
        chance = f", predicted chance {found.score:.0%}" if found.score > 0 else ""
        return f"**{strategy}** can take it{chance}{f' ({factors})' if factors else ''}: {escape_markdown(reason)}."
    return f"⚠ **{strategy}** cannot take it: {escape_markdown(found.reason)}. {best}"


def format_ranking(candidates: Sequence[Candidate]) -> str:
    """What the models predict for all strategies, a line each."""
    return _CHANCE + "\n".join(
        f"- **{each.strategy}** {_format_score(each)}: {escape_markdown(_split_reason(each)[0])}" for each in candidates
    )


def _format_score(candidate: Candidate) -> str:
    if not candidate.feasible:
        return "✗ no"
    _, factors = _split_reason(candidate)
    told = f" ({factors})" if "times" in factors else ""
    return f"✓ {candidate.score:.0%}{told}" if candidate.score > 0 else "✓"


def _split_reason(candidate: Candidate) -> tuple[str, str]:
    """What decides, and how the chance follows from the rate of success that was measured in simulation."""
    reason, _, told = candidate.reason.partition(RATE)
    rate, comma, factors = told.partition(", ")
    if not rate:
        return reason, ""
    if not comma:
        return reason, "the rate of success in simulation"
    return reason, f"rate of success in simulation {float(rate):.0%}, {factors}"


def describe_frame(frames: Frames, index: int) -> str:
    """Phase, action and time of a frame."""
    return f"**{frames.phase[index]}**: {frames.action[index]}, {frames.time[index]:.1f} s"


def describe_phases(frames: Frames) -> str:
    """Phases with the times at which they begin, in a line."""
    return "Phases: " + ", ".join(f"{phase} from {begin:.1f} s" for phase, begin, _ in frames.spans())


def describe_reload(running: str, shown: str) -> str:
    """That a reload stopped a grasp.

    Args:
        running: object and strategy of the grasp that was stopped.
        shown: those of the grasp that is shown instead; empty where none is.
    """
    rest = f" What is shown is the grasp before, of {shown}." if shown else ""
    return f"The grasp of {running} was stopped by the reload.{rest}"


def describe_result(result: dict[str, Any]) -> str:
    """How a trial ended, in words.

    Args:
        result: as `compute_result` gives it.
    """
    if result.get("attempts") == []:
        reason = result["reason"].removeprefix("no strategy can take it: ")
        return f"**No strategy can take it:** {escape_markdown(reason)}"
    head = "**Success.**" if result["success"] else f"**Failed:** {escape_markdown(result['reason'])}."
    if result["cause"] is not None:
        head += f" Cause: **{result['cause']}** at {result['cause_time_s']:.1f} s."
    if result["success"] and result["hold_s"]:
        held, place = result["hold_s"], _format(result["place_error_m"], 1e3, "mm")
        head += f" Held by the trunk alone for {held:.1f} s, set down {place} from its place."
    elif result["success"]:
        head += f" Moved along the ground by {_format(result['carry_m'], 1e3, 'mm')}."
    tried = [each["strategy"] for each in result.get("attempts", ())]
    return f"{head} Tried: {', '.join(tried)}." if tried else head


def format_figures(result: dict[str, Any]) -> str:
    """Figures of a trial, as a table."""
    rows = "".join(f"\n| {name} | {value} |" for name, value in _list_figures(result))
    return f"| figure | value |\n|---|---:|{rows}"


def _list_figures(result: dict[str, Any]) -> list[tuple[str, str]]:
    return [
        ("lifted", _format(result["lift_m"], 1e3, "mm")),
        ("carried", _format(result["carry_m"], 1e3, "mm")),
        ("held by the trunk alone", _format(result["hold_s"], 1.0, "s")),
        ("set down from the target", _format(result["place_error_m"], 1e3, "mm")),
        ("largest joint angle", _format(result["max_joint_deg"], 1.0, "°")),
        ("deepest overlap", _format(result["max_penetration_m"], 1e3, "mm")),
        ("friction of the object", _format(result["world"]["friction"], 1.0, "")),
        ("true width", _format(result["world"]["width_m"], 1e3, "mm")),
        ("true mass", _format(result["world"]["mass_kg"], 1e3, "g")),
        ("computed at", _format(result["real_time_factor"], 1.0, "x real time")),
    ]


def _format(value: float | None, factor: float, unit: str) -> str:
    return "-" if value is None else f"{value * factor:.3g} {unit}".rstrip()
