"""What a session of motion capture is to do, as data: runs of shapes, how they are held, how a recording is read.

The packaged protocol is the paper's (26 steps of 5 mm on one cable, rest at four tilts; Methods, "Model Validation via
Motion Capture System") and a twist of ours.
"""

from __future__ import annotations

import math
import os
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import final

from spiraltrunk.errors import TakeError
from spiraltrunk.mocap.signal.registration import Alignment
from spiraltrunk.mocap.signal.segmentation import StillSettings
from spiraltrunk.model.kinematics.measured_shapes import KINDS

ORIENTATIONS = ("markers", "body", "none")
"""Where a section's axes come from."""

MOST_STEPS = 1000

_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._+-]{0,59}")


@final
@dataclass(frozen=True, kw_only=True)
class Run:
    """Shapes that are taken one after the other; at rest there is one."""

    name: str
    """What it is called; recordings whose file names begin with it are its takes."""
    kind: str
    """What is pulled, one of `KINDS`."""
    theta_0: float = math.pi / 2
    """Angle of the base axis below the horizontal [rad]."""
    steps: int = 0
    """Steps after the first shape."""
    step: float = 0.0
    """What a step adds: cable 1 pulled in (bend-dorsal), lengthened (bend-ventral), cable 2 pulled in (twist) [m]."""
    first: float = 0.0
    """What cable 1 is pulled in by before a twist [m]."""
    takes: int = 1
    """Recordings that are averaged."""
    begin: float | None = None
    """Time of the recording before which nothing counts [s]."""
    end: float | None = None
    """Time of the recording after which nothing counts [s]."""
    period: float | None = None
    """Time from shape to shape where steps are timed and not sought by motion, the first from ``begin`` on [s]."""

    def __post_init__(self) -> None:
        if not _NAME.fullmatch(self.name):
            allowed = "1 to 60 letters, digits, dots, dashes, beginning with a letter or digit"
            raise TakeError(f"run's name is {self.name[:80]!r}; allowed: {allowed}")
        if self.kind not in KINDS:
            self._refuse("kind", self.kind, ", ".join(KINDS))
        if not (math.isfinite(self.theta_0) and abs(self.theta_0) <= 2 * math.pi):
            self._refuse("theta_0", self.theta_0, "finite, at most one turn")
        is_rest = self.kind == "rest"
        if not (0 if is_rest else 1) <= self.steps <= (0 if is_rest else MOST_STEPS):
            self._refuse("steps", self.steps, "none at rest" if is_rest else f"1 to {MOST_STEPS}")
        if not (self.step == 0 if is_rest else 0 < self.step < 1):
            self._refuse("step_mm", 1e3 * self.step, "none at rest" if is_rest else "above 0, below 1000")
        if not (0 < self.first < 1 if self.kind == "twist" else self.first == 0):
            self._refuse(
                "first_mm", 1e3 * self.first, "above 0, below 1000" if self.kind == "twist" else "with a twist"
            )
        if not 1 <= self.takes <= 100:
            self._refuse("takes", self.takes, "1 to 100")
        self._check_times()

    @property
    def n_shape(self) -> int:
        """Shapes that a take of it holds."""
        return self.steps + 1

    def _check_times(self) -> None:
        for name in ("begin", "end"):
            value = getattr(self, name)
            if value is not None and not math.isfinite(value):
                self._refuse(f"{name}_s", value, "a finite time")
        if self.begin is not None and self.end is not None and self.begin >= self.end:
            self._refuse("end_s", self.end, f"after begin_s, {self.begin:g}")
        if self.period is not None and not (self.begin is not None and 0.1 <= self.period <= 3600):
            self._refuse("period_s", self.period, "0.1 to 3600, with begin_s, when the first shape begins")

    def _refuse(self, name: str, got: object, allowed: str) -> None:
        raise TakeError(f"run {self.name!r}: {name} is {got!r}; allowed: {allowed}")


@final
@dataclass(frozen=True, kw_only=True)
class Protocol:
    """A session."""

    name: str
    """What it is called."""
    runs: tuple[Run, ...]
    """Its runs."""
    design: str = "paper"
    """Preset or file of the trunk."""
    axes: str | None = None
    """Axis convention of the recordings; None where it is told elsewhere."""
    alignment: Alignment = Alignment()  # noqa: RUF009
    """How recordings are brought into the model's frame."""
    orientation: str = "markers"
    """Where sections' axes come from, one of `ORIENTATIONS`."""
    rotations: str = "quaternion"
    """Whether rotations of rigid bodies are read ("quaternion") or ignored ("ignore")."""
    base: str = "base"
    """Rigid body at the trunk's base: origin where section 1 begins, x along the base axis, y dorsal."""
    slack: tuple[float, ...] = (0.0, 0.0, 0.0)
    """Residual slack of each cable, measured on the fully wrapped trunk: the paper's L_slack [m]."""
    sections: tuple[tuple[int, str], ...] = ()
    """Names of rigid bodies or markers of sections, from 1; without them section_01, section_02 and so on."""
    still: StillSettings = StillSettings()  # noqa: RUF009
    """What counts as a held shape."""

    def __post_init__(self) -> None:
        if not 1 <= len(self.runs) <= 200:
            raise TakeError(f"the protocol has {len(self.runs)} runs; allowed: 1 to 200")
        names = [run.name for run in self.runs]
        for name in names:
            if names.count(name) > 1:
                raise TakeError(f"two runs are called {name!r}; allowed: a name of its own for each")
        if self.orientation not in ORIENTATIONS:
            raise TakeError(f"orientation is {self.orientation[:40]!r}; allowed: {', '.join(ORIENTATIONS)}")
        if self.rotations not in ("quaternion", "ignore"):
            raise TakeError(f"rotations are {self.rotations[:40]!r}; allowed: quaternion or ignore")
        if not all(math.isfinite(value) and 0 <= value < 0.1 for value in self.slack):
            raise TakeError(f"slack is {self.slack} m; allowed: 0 to 100 mm each")

    def run(self, name: str) -> Run:
        """The run of that name.

        Raises:
            TakeError: where there is none; it lists those that are.
        """
        for run in self.runs:
            if run.name == name:
                return run
        raise TakeError(f"there is no run {name[:80]!r}; allowed: {', '.join(run.name for run in self.runs)}")


def sort_takes(protocol: Protocol, given: Sequence[str]) -> dict[str, list[str]]:
    """Recordings by run, in the protocol's order: each RUN=FILE, or a file whose name begins with a run's.

    Raises:
        TakeError: for a file that belongs to no run, or is there twice for one.
    """
    names = [run.name for run in protocol.runs]
    found: dict[str, list[str]] = {name: [] for name in names}
    for text in given:
        run, file = _find_run(text, names)
        if os.path.realpath(file) in map(os.path.realpath, found[run]):
            raise TakeError(f"{file[:200]!r} is given twice for run {run!r}; allowed: once")
        found[run].append(file)
    return {run: files for run, files in found.items() if files}


def _find_run(text: str, names: Sequence[str]) -> tuple[str, str]:
    """Run and file of what was given."""
    run, equals, file = text.partition("=")
    if equals and run in names and file:
        return run, file
    if equals and run and run not in names and "/" not in run and not _exists(text):
        told = f"{text[:200]!r}: {run[:60]!r} is no run"
        raise TakeError(f"{told}; allowed: RUN=FILE, where RUN is one of {', '.join(names)}")
    stem = re.split(r"[/\\]", text)[-1].lower()
    run = max((name for name in names if _begins(stem, name)), key=len, default="")
    if not run or (equals and not file):
        allowed = f"RUN=FILE, or a file whose name begins with the run's; runs are {', '.join(names)}"
        raise TakeError(f"{text[:200]!r} belongs to no run; allowed: {allowed}")
    return run, text


def _exists(path: str) -> bool:
    try:
        return Path(path).exists()
    except (OSError, ValueError):  # No disc takes such a name.
        return False


def _begins(stem: str, name: str) -> bool:
    """Whether a file's name is the run's, perhaps with more after a sign that is no letter or digit."""
    rest = stem.removeprefix(name.lower())
    return rest != stem and not rest[:1].isalnum()
