"""Protocol of a motion-capture session: runs of shapes, how they are held, and how recordings are read.

The packaged protocol is the paper's (26 steps of 5 mm on one cable, rest at four tilts; Methods, "Model Validation via
Motion Capture System") and a twist of ours.
"""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import final

from spiraltrunk.errors import TakeError
from spiraltrunk.field_docs import explain_fields
from spiraltrunk.mocap.signal.registration import Alignment
from spiraltrunk.mocap.signal.segmentation import StillSettings
from spiraltrunk.model.kinematics.measured_shapes import KINDS

ORIENTATIONS = ("markers", "body", "none")
"""Sources of a section's axes."""

MOST_STEPS = 1000

_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._+-]{0,59}")


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class Run:
    """Shapes recorded one after the other; one at rest."""

    name: str
    """Its name; recordings whose file names begin with it are its takes."""
    kind: str
    """Which cables are pulled, one of `KINDS`."""
    theta_0: float = math.pi / 2
    """Angle of the base axis below the horizontal [rad]."""
    steps: int = 0
    """Steps after the first shape."""
    step: float = 0.0
    """Length of a step: cable 1 pulled in (bend-dorsal), lengthened (bend-ventral), cable 2 pulled in (twist) [m]."""
    first: float = 0.0
    """Length by which cable 1 is pulled in before a twist [m]."""
    takes: int = 1
    """Number of recordings, which are averaged."""
    begin: float | None = None
    """Start of the evaluated part of the recording [s]."""
    end: float | None = None
    """End of the evaluated part [s]."""
    period: float | None = None
    """Time from shape to shape for timed steps, the first from ``begin`` on; None segments by motion [s]."""

    def __post_init__(self) -> None:
        if not _NAME.fullmatch(self.name):
            allowed = "1 to 60 letters, digits, dots, dashes, beginning with a letter or digit"
            raise TakeError(f"run's name is {self.name[:80]!r}; allowed: {allowed}")
        is_rest, is_twist = self.kind == "rest", self.kind == "twist"
        begin = math.nan if self.begin is None else self.begin
        none = "none at rest"
        rules = (
            ("kind", self.kind, self.kind in KINDS, ", ".join(KINDS)),
            ("theta_0", self.theta_0, abs(self.theta_0) <= 2 * math.pi, "finite, at most one turn"),
            ("steps", self.steps, self.steps == 0 if is_rest else 1 <= self.steps <= MOST_STEPS,
             none if is_rest else f"1 to {MOST_STEPS}"),
            ("step_mm", 1e3 * self.step, self.step == 0 if is_rest else 0 < self.step < 1,
             none if is_rest else "above 0, below 1000"),
            ("first_mm", 1e3 * self.first, 0 < self.first < 1 if is_twist else self.first == 0,
             "above 0, below 1000" if is_twist else "with a twist"),
            ("takes", self.takes, 1 <= self.takes <= 100, "1 to 100"),
            ("begin_s", self.begin, self.begin is None or math.isfinite(begin), "a finite time"),
            ("end_s", self.end, self.end is None or self.end > (-math.inf if self.begin is None else begin),
             f"after begin_s, {begin:g}"),
            ("period_s", self.period, self.period is None or (math.isfinite(begin) and 0.1 <= self.period <= 3600),
             "0.1 to 3600, with begin_s, when the first shape begins"),
        )  # fmt: skip
        for key, got, holds, allowed in rules:
            if not holds:
                raise TakeError(f"run {self.name!r}: {key} is {got!r}; allowed: {allowed}")
        if self.name == "rest" and not is_rest:
            allowed = "rest, as the run's name is that of the plots of all runs at rest, or another name"
            raise TakeError(f"run 'rest': kind is {self.kind!r}; allowed: {allowed}")

    @property
    def n_shape(self) -> int:
        """Shapes of each of its takes."""
        return self.steps + 1


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class Protocol:
    """A session."""

    name: str
    """Name that files and tables show."""
    runs: tuple[Run, ...]
    """Runs in the order in which they are recorded."""
    design: str = "paper"
    """Preset or file of the trunk."""
    axes: str | None = None
    """Axis convention of the recordings; None if it is given elsewhere."""
    alignment: Alignment = Alignment()  # noqa: RUF009
    """How recordings are registered to the model's frame."""
    orientation: str = "markers"
    """Source of the sections' axes, one of `ORIENTATIONS`."""
    rotations: str = "quaternion"
    """Whether rotations of rigid bodies are read ("quaternion") or ignored ("ignore")."""
    base: str = "base"
    """Rigid body at the trunk's base: origin where section 1 begins, x along the base axis, y dorsal."""
    slack: tuple[float, ...] = (0.0, 0.0, 0.0)
    """Residual slack of each cable on the fully wrapped trunk, the paper's L_slack [m]."""
    sections: tuple[tuple[int, str], ...] = ()
    """Names of rigid bodies or markers of sections, from 1; without them section_01, section_02 and so on."""
    still: StillSettings = StillSettings()  # noqa: RUF009
    """Criteria of a held shape."""

    def __post_init__(self) -> None:
        if not 1 <= len(self.runs) <= 200:
            raise TakeError(f"the protocol has {len(self.runs)} runs; allowed: 1 to 200")
        for name, count in Counter(run.name for run in self.runs).items():
            if count > 1:
                raise TakeError(f"two runs are called {name!r}; allowed: a name of its own for each")
        if self.orientation not in ORIENTATIONS:
            raise TakeError(f"orientation is {self.orientation[:40]!r}; allowed: {', '.join(ORIENTATIONS)}")
        if self.rotations not in ("quaternion", "ignore"):
            raise TakeError(f"rotations are {self.rotations[:40]!r}; allowed: quaternion or ignore")
        if not all(math.isfinite(value) and 0 <= value < 0.1 for value in self.slack):
            raise TakeError(f"slack is {self.slack} m; allowed: 0 to 100 mm each")
        self._check_sections()

    def _check_sections(self) -> None:
        for number, name in self.sections:
            if number < 1:
                raise TakeError(f"sections has {number} for {name[:40]!r}; allowed: 1 at the base, and above")
        for i, what in enumerate(("number", "name")):
            for value, count in Counter(section[i] for section in self.sections).items():
                if count > 1:
                    told = value if isinstance(value, int) else value[:40]
                    raise TakeError(f"sections has the {what} {told!r} {count} times; allowed: once")

    def run(self, name: str) -> Run:
        """The run of that name; the error where there is none lists those that are."""
        runs = {run.name: run for run in self.runs}
        if name not in runs:
            raise TakeError(f"unknown run {name[:80]!r}; known: {', '.join(runs)}")
        return runs[name]


def sort_takes(protocol: Protocol, given: Sequence[str]) -> dict[str, list[str]]:
    """Recordings by run, in the protocol's order: each RUN=FILE, or a file whose name begins with a run's.

    Raises:
        TakeError: for a file that belongs to no run, or is given twice for one.
    """
    found: dict[str, list[str]] = {run.name: [] for run in protocol.runs}
    for text in given:
        run, file = _find_run(text, protocol)
        if Path(file).resolve() in [Path(other).resolve() for other in found[run]]:
            raise TakeError(f"{file[:200]!r} is given twice for run {run!r}; allowed: once")
        found[run].append(file)
    return {run: files for run, files in found.items() if files}


def guess_run(protocol: Protocol, file_name: str) -> str | None:
    """The run whose name a file's name begins with, the longest of them; None where there is none.

    Args:
        protocol: the session.
        file_name: name of a file, in any case, with or without its folder; nothing is looked up.
    """
    stem = re.split(r"[/\\]", file_name)[-1].lower()
    names = [run.name for run in protocol.runs]
    fitting = [name for name in names if stem.startswith(name.lower()) and not stem[len(name) :][:1].isalnum()]
    return max(fitting, key=len, default=None)


def _find_run(text: str, protocol: Protocol) -> tuple[str, str]:
    """Run and file of an argument."""
    names = [run.name for run in protocol.runs]
    run, equals, file = text.partition("=")
    if run in names and file:
        return run, file
    guessed = None if equals else guess_run(protocol, text)
    if guessed is None:
        allowed = f"RUN=FILE, or a file whose name begins with the run's; runs are {', '.join(names)}"
        reason = "is a folder" if Path(text).is_dir() else "belongs to no run"
        raise TakeError(f"{text[:200]!r} {reason}; allowed: {allowed}")
    return guessed, text
