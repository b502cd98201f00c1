"""What is recorded of each trial."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any, final

from spiraltrunk.checks import check_count
from spiraltrunk.control.encoding import ControlMode, parse_control_mode
from spiraltrunk.control.plant import CONTROL_PERIOD
from spiraltrunk.errors import DesignError, UnknownName
from spiraltrunk.field_docs import explain_fields
from spiraltrunk.sim.photographer import CAMERAS

CONTROL_RATE = round(1 / CONTROL_PERIOD)
"""Commands per second [1/s]."""

RATES = tuple(rate for rate in range(1, CONTROL_RATE + 1) if CONTROL_RATE % rate == 0)
"""Frames per second that are a whole number of commands apart [1/s]."""

PICTURE_RATE = 10
"""Frames per second with cameras, where no rate is asked for [1/s]: a picture costs about as much as four commands."""

PICTURE_SIZE = 96
"""Width and height of a picture, where none is asked for [pixels]."""

LEAST_SIZE, MOST_SIZE = 16, 512
"""Least and largest width and height of a picture [pixels] (ours)."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class RecordingOptions:
    """What is recorded of each trial."""

    cameras: tuple[str, ...] = ()
    """Cameras that see every frame, by their names in `spiraltrunk.sim.photographer`."""
    size: int = PICTURE_SIZE
    """Width and height of the pictures [pixels]."""
    fps: int = CONTROL_RATE
    """Frames per second of simulated time [1/s]."""
    mode: str = ControlMode.DELTA_POSE_TENSION_PULL.value
    """What an action sets: a control mode by its name. The default alone says all that the strategies command."""
    keeps_failures: bool = False
    """Whether failed trials are recorded as well."""

    def __post_init__(self) -> None:
        for name in self.cameras:
            if name not in CAMERAS:
                raise UnknownName("camera", name, CAMERAS)
        if len(set(self.cameras)) < len(self.cameras):
            raise DesignError("demos.cameras", got=",".join(self.cameras), allowed="each camera once")
        parse_control_mode(self.mode)
        check_count("demos.size", self.size, least=LEAST_SIZE, most=MOST_SIZE)
        if self.size % 2:
            raise DesignError("demos.size", got=self.size, allowed="an even number, as videos need")
        if isinstance(self.fps, bool) or self.fps not in RATES:
            rates = ", ".join(map(str, RATES))
            raise DesignError("demos.fps", got=self.fps, allowed=f"{rates}: whole numbers of commands apart")

    @property
    def stride(self) -> int:
        """Commands from one frame to the next [-]."""
        return CONTROL_RATE // self.fps

    def settings(self) -> dict[str, Any]:
        """Settings that are equal for equal recordings, ready for JSON."""
        return {**asdict(self), "cameras": list(self.cameras)}
