"""Poses saved by name: how far each cable is wound in, in a JSON file of the user.

{"format": "spiraltrunk poses 1", "poses": {"curled": {"pulls_mm": [60.0, -10.0, -10.0]}}}
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple, NoReturn, final

from spiraltrunk.checks import check_numbers, check_text
from spiraltrunk.errors import DesignError, DriveError, OutputError, SpiralTrunkError, UnknownName, describe
from spiraltrunk.files.atomic import check_place, write_text
from spiraltrunk.files.text_lines import check_regular

FORMAT = "spiraltrunk poses 1"
"""What a file of poses says of itself."""
SIZE_MAX = 1_000_000
"""Largest file that is read [bytes] (ours)."""
NAME_MAX = 60
"""Longest name [characters] (ours)."""
HINT = "`drive pose NAME --save MM MM MM`, with the length of each cable,"
"""Command that saves a pose."""


@final
class PullLimits(NamedTuple):
    """How far cables may be wound in, since the straight, just taut trunk."""

    least: tuple[float, ...]
    """Least pull of each cable [m]; negative when it is paid out."""
    most: tuple[float, ...]
    """Largest pull of each cable [m]."""


@final
@dataclass(frozen=True)
class Pose:
    """One pose."""

    name: str
    """Its name."""
    pulls: tuple[float, ...]
    """Cable wound in since the straight, just taut trunk, per cable [m]."""

    def __post_init__(self) -> None:
        check_text("name of a pose", self.name, most=NAME_MAX)
        check_numbers(f"pulls of pose {self.name!r}", self.pulls, least=-10.0, most=10.0)


def check_pose(pose: Pose, limits: PullLimits) -> None:
    """Refuse a pose that does not fit the design.

    Raises:
        DriveError: with the cable, its pull and what is allowed.
    """
    if len(pose.pulls) != len(limits.least):
        raise DriveError(f"pose {pose.name!r} has {len(pose.pulls)} pulls; allowed: {len(limits.least)}, one per cable")
    for cable, (pull, least, most) in enumerate(zip(pose.pulls, *limits, strict=True), start=1):
        if not least <= pull <= most:
            raise DriveError(
                f"pose {pose.name!r}: pull of cable {cable} is {1e3 * pull:g} mm; "
                f"allowed: {1e3 * least:g} to {1e3 * most:g} mm"
            )


def find_pose(poses: Mapping[str, Pose], name: str) -> Pose:
    """The pose of this name.

    Raises:
        DriveError: where there is no pose.
        UnknownName: with the names that exist.
    """
    if not poses:
        raise DriveError(f"unknown pose {describe(name)}; known: none yet, {HINT} saves one")
    if name not in poses:
        raise UnknownName("pose", name, sorted(poses))
    return poses[name]


def load_poses(path: str | Path, limits: PullLimits) -> dict[str, Pose]:
    """Poses of a file by name, each checked against the limits; none of a file that does not exist.

    Raises:
        DriveError: where the file cannot be read, is not one of poses, or a pose does not fit; none is returned then.
    """
    try:
        check_regular(Path(path))
        with Path(path).open("rb") as file:
            data = file.read(SIZE_MAX + 1)
    except FileNotFoundError:
        return {}
    except (OSError, ValueError) as error:
        allowed = f"allowed: a file of poses, which {HINT} makes"
        raise DriveError(f"{describe(str(path))} cannot be read: {_explain(error)}; {allowed}") from error
    try:
        poses = _read_poses(data)
        for pose in poses.values():
            check_pose(pose, limits)
    except SpiralTrunkError as error:
        raise DriveError(f"{describe(str(path))}: {error}") from error
    return poses


def write_poses(path: str | Path, poses: Mapping[str, Pose]) -> None:
    """Replace a file of poses by these, or leave it as it was.

    Raises:
        OutputError: where it cannot be written, or there is a file that holds no poses.
    """
    existing = Path(path)
    try:
        check_regular(existing)
        if existing.exists():
            with existing.open("rb") as file:
                _read_poses(file.read(SIZE_MAX + 1))
    except (OSError, SpiralTrunkError) as error:
        reason = f"it holds no poses ({_explain(error)})"
        raise OutputError(f"{describe(str(path))} is kept: {reason}; choose another name") from error
    entries = {name: {"pulls_mm": [1e3 * pull for pull in pose.pulls]} for name, pose in sorted(poses.items())}
    text = json.dumps({"format": FORMAT, "poses": entries}, indent=2, ensure_ascii=False, allow_nan=False)
    try:
        write_text(path, text + "\n")
    except OSError as error:
        raise _refuse_place(path, error) from error


def check_poses_place(path: str | Path) -> None:
    """Refuse a place where no file can be written; nothing stays there.

    Raises:
        OutputError: with the place and the reason.
    """
    try:
        check_place(path)
    except OSError as error:
        raise _refuse_place(path, error) from error


def _refuse_place(path: str | Path, error: OSError) -> OutputError:
    allowed = "allowed: a file in a folder that can be written"
    return OutputError(f"{describe(str(path))} cannot be written: {_explain(error)}; {allowed}")


def save_pose(path: str | Path, pose: Pose, limits: PullLimits) -> None:
    """Save a pose in a file of poses; one of the same name is replaced.

    Raises:
        DriveError: where the pose, or the file, does not fit; nothing is written then.
        OutputError: where the file cannot be written.
    """
    check_pose(pose, limits)
    write_poses(path, load_poses(path, limits) | {pose.name: pose})


def _explain(error: Exception) -> str:
    """Why a file cannot be used; of errors of `check_regular` their own words."""
    return str(getattr(error, "strerror", None) or error)


def _read_poses(data: bytes) -> dict[str, Pose]:
    if len(data) > SIZE_MAX:
        raise DriveError(f"larger than {SIZE_MAX / 1e6:g} MB; allowed: a file of poses")
    try:
        content = json.loads(data.decode(), object_pairs_hook=_refuse_doubles, parse_constant=_refuse_constant)
    except (ValueError, RecursionError) as error:
        nested = "its arrays are nested too deeply" if isinstance(error, RecursionError) else str(error)
        digits = "a number has too many digits" if "set_int_max_str_digits" in nested else nested
        raise DriveError(f"no JSON: {digits}; allowed: a file of poses") from error
    if not isinstance(content, dict) or set(content) != {"format", "poses"} or content["format"] != FORMAT:
        raise DriveError(f"begins with {describe(content, 40)}; allowed: a table of 'format' ({FORMAT!r}) and 'poses'")
    if not isinstance(content["poses"], dict):
        raise DriveError(f"poses is {describe(content['poses'], 40)}; allowed: a table of poses by name")
    return {name: _read_pose(name, entry) for name, entry in content["poses"].items()}


def _read_pose(name: str, entry: object) -> Pose:
    pulls = entry.get("pulls_mm") if isinstance(entry, dict) and set(entry) == {"pulls_mm"} else None
    if not isinstance(pulls, list) or not all(type(pull) in (int, float) for pull in pulls):
        raise DriveError(f"pose {name!r} is {describe(entry, 40)}; allowed: a table of 'pulls_mm', a list of numbers")
    return Pose(name, tuple(_convert(name, pulls)))


def _convert(name: str, pulls: Sequence[float]) -> list[float]:
    try:
        return [1e-3 * pull for pull in pulls]
    except OverflowError:
        raise DesignError(f"pulls_mm of pose {name!r}", got=pulls, allowed="numbers of mm") from None


def _refuse_doubles(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    table = dict(pairs)
    if len(table) < len(pairs):
        names = [name for name, _ in pairs]
        twice = next(name for name in names if names.count(name) > 1)
        raise DriveError(f"the name {describe(twice)} stands twice; allowed: each name once")
    return table


def _refuse_constant(constant: str) -> NoReturn:
    raise DriveError(f"holds {constant}; allowed: finite numbers")
