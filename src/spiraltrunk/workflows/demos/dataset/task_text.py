"""The task of an episode as a sentence, for policies that take language."""

from __future__ import annotations

from typing import Any

from spiraltrunk.workflows.demos.recording.episode import Episode


def describe_episode(episode: Episode) -> str:
    """What was asked for, with the announced object's measures, and the strategy that did it.

    Episodes with equal objects, tasks and strategies have equal texts.
    """
    strategy, job, task = (episode.about[key] for key in ("strategy", "job", "task"))
    what = _describe_object(task["target"], episode.about["world"])
    if job == "kick":
        return f"kick {what} along the ground ({strategy})"
    put = f"lift it {_mm(task['goal']['lift'])}, carry it aside, hold it {task['goal']['hold']:g} s and set it down"
    push = f"sweep {what} to its place, grasp it there" if job == "sweep" else f"grasp {what}"
    return f"{push}, {put} ({strategy})"


def _describe_object(target: dict[str, Any], world: dict[str, Any]) -> str:
    width, length = _mm(target["width"]), _mm(target["length"])
    size = f"{width} wide" if target["kind"] == "sphere" else f"{width} wide and {length} long"
    pose = "hanging" if world["support"] == "hung" else "standing" if world["orientation"] == "upright" else "lying"
    return f"the {pose} {target['kind']}, {size}"


def _mm(length: float) -> str:
    return f"{1e3 * length:.0f} mm"
