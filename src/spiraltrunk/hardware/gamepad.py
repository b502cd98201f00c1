"""A gamepad that jogs the cables: the left stick bends the trunk, the right one tightens or loosens all cables.

The mapping is a function of what the gamepad reports and of the state before; pygame only reads the device. A gamepad
that is gone, or reports what none can, stops; so does its stop button. After a stop the sticks must come back to their
middle before anything moves. Never tried with a real gamepad.
"""

from __future__ import annotations

import math
import os
from dataclasses import dataclass
from typing import Any, NamedTuple, Self, final

from spiraltrunk.checks import check_count, check_number, check_type
from spiraltrunk.errors import DesignError, DriveError, MissingPackage
from spiraltrunk.field_docs import explain_fields


@final
class GamepadInput(NamedTuple):
    """What a gamepad reports."""

    is_connected: bool
    """Whether it is there."""
    axes: tuple[float, ...]
    """Positions of the sticks' axes, -1 to 1; right and down are positive."""
    buttons: tuple[bool, ...]
    """Whether each button is pressed."""


@explain_fields
@final
@dataclass(frozen=True, kw_only=True)
class GamepadSettings:
    """How sticks and buttons become speeds.

    The numbers of axes and buttons are those of SDL's common layout; they differ between gamepads (unconfirmed).
    """

    directions: tuple[tuple[float, float], ...]
    """Unit vector from the backbone to each cable in the section's plane [-]."""
    speed_slow: float = 0.005
    """Speed of a cable at full deflection [m/s] (ours)."""
    speed_fast: float = 0.02
    """The same while the fast button is pressed [m/s] (ours)."""
    acceleration: float = 0.05
    """Largest change of a cable's speed [m/s^2] (ours)."""
    dead_zone: float = 0.15
    """Deflection below which a stick is in its middle [-] (ours)."""
    bend_axes: tuple[int, int] = (0, 1)
    """Axes of the stick that bends: right, and down."""
    tighten_axis: int = 3
    """Axis that tightens all cables; down is positive, and tightens."""
    fast_button: int = 5
    """Button that is held for the fast speed."""
    stop_button: int = 1
    """Button that stops."""

    def __post_init__(self) -> None:
        check_type("directions", self.directions, tuple)
        if not self.directions or not all(len(d) == 2 and math.isclose(math.hypot(*d), 1.0) for d in self.directions):
            raise DesignError("directions", got=self.directions, allowed="one unit vector of two numbers per cable")
        check_number("speed_slow", self.speed_slow, above=0.0, most=0.5)
        check_number("speed_fast", self.speed_fast, least=self.speed_slow, most=0.5)
        check_number("acceleration", self.acceleration, above=0.0, most=10.0)
        check_number("dead_zone", self.dead_zone, least=0.01, most=0.9)
        numbers = (*self.bend_axes, self.tighten_axis, self.fast_button, self.stop_button)
        for name, value in zip(
            ("bend_axes", "bend_axes", "tighten_axis", "fast_button", "stop_button"), numbers, strict=True
        ):
            check_count(name, value, least=0, most=31)


@final
class JogState(NamedTuple):
    """What the gamepad commands now."""

    speeds: tuple[float, ...]
    """Speed of each cable [m/s], positive when it is wound in."""
    stop: str
    """Why everything stops; empty where nothing does."""
    is_centred: bool
    """Whether the sticks have been in their middle since the last stop."""


def init_jog(settings: GamepadSettings) -> JogState:
    """State at the start: at rest, and the sticks have yet to be seen in their middle."""
    return JogState((0.0,) * len(settings.directions), "", is_centred=False)


def step_jog(settings: GamepadSettings, state: JogState, seen: GamepadInput, dt: float) -> JogState:
    """State after ``dt`` [s] with this input.

    Speed of cable i: ``v (s . d_i + t)``, limited to ``v``, with the bending stick s and the tightening one t rescaled
    behind the dead zone, ``|s| -> (|s| - z) / (1 - z)``, and the cable's direction d_i; it approaches that by at most
    ``acceleration * dt``. A stop ends all speeds at once.
    """
    rest = (0.0,) * len(settings.directions)
    if why := _find_stop(settings, seen, dt):
        return JogState(rest, why, is_centred=False)
    right, down = (seen.axes[axis] for axis in settings.bend_axes)
    bend_x, bend_y = _rescale(right, -down, settings.dead_zone)
    tighten, _ = _rescale(seen.axes[settings.tighten_axis], 0.0, settings.dead_zone)
    is_centred = state.is_centred or bend_x == bend_y == tighten == 0.0
    if not is_centred:
        return JogState(rest, "", is_centred=False)
    speed = settings.speed_fast if seen.buttons[settings.fast_button] else settings.speed_slow
    change = settings.acceleration * dt
    speeds = []
    for before, (x, y) in zip(state.speeds, settings.directions, strict=True):
        wanted = speed * _limit(bend_x * x + bend_y * y + tighten, 1.0)
        speeds.append(before + _limit(wanted - before, change))
    return JogState(tuple(speeds), "", is_centred=True)


def _find_stop(settings: GamepadSettings, seen: GamepadInput, dt: float) -> str:
    """Why everything stops; empty where nothing does."""
    if not seen.is_connected:
        return "the gamepad is gone"
    n_axis = 1 + max(*settings.bend_axes, settings.tighten_axis)
    n_button = 1 + max(settings.fast_button, settings.stop_button)
    if len(seen.axes) < n_axis or len(seen.buttons) < n_button:
        return f"the gamepad has {len(seen.axes)} axes and {len(seen.buttons)} buttons; needed: {n_axis} and {n_button}"
    if not all(-1.001 <= axis <= 1.001 for axis in seen.axes) or not 0.0 < dt <= 1.0:  # Not true of NaN either.
        return "the gamepad reports an axis beyond -1 to 1, or too seldom"
    return "stop button" if seen.buttons[settings.stop_button] else ""


def _rescale(x: float, y: float, dead_zone: float) -> tuple[float, float]:
    length = math.hypot(x, y)
    if length <= dead_zone:
        return 0.0, 0.0
    factor = min(1.0, (length - dead_zone) / (1.0 - dead_zone)) / length
    return factor * x, factor * y


def _limit(value: float, most: float) -> float:
    return max(-most, min(most, value))


@final
class Gamepad:
    """A gamepad at this computer."""

    def __init__(self, index: int = 0) -> None:
        """Open the gamepad of this number.

        Raises:
            DriveError: where there is none, with those that are found.
            MissingPackage: without pygame.
        """
        self._pygame = _load_pygame()
        joystick = self._pygame.joystick
        names = [joystick.Joystick(i).get_name() for i in range(joystick.get_count())]
        if not 0 <= index < len(names):
            found = ", ".join(f"{i} ({name})" for i, name in enumerate(names)) or "none"
            raise DriveError(f"no gamepad {index}; found: {found}")
        self._device = joystick.Joystick(index)
        self._id = self._device.get_instance_id()
        self._is_connected = True

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def read(self) -> GamepadInput:
        """What it reports now; never waits. Once gone, it stays so."""
        removed = self._pygame.event.get(self._pygame.JOYDEVICEREMOVED)
        if any(event.instance_id == self._id for event in removed):
            self._is_connected = False
        self._pygame.event.clear()
        if not self._is_connected:
            return GamepadInput(is_connected=False, axes=(), buttons=())
        try:
            axes = tuple(self._device.get_axis(i) for i in range(self._device.get_numaxes()))
            buttons = tuple(bool(self._device.get_button(i)) for i in range(self._device.get_numbuttons()))
        except self._pygame.error:
            self._is_connected = False
            return GamepadInput(is_connected=False, axes=(), buttons=())
        return GamepadInput(is_connected=True, axes=axes, buttons=buttons)

    def close(self) -> None:
        """Release it; harmless when called again."""
        self._is_connected = False
        self._pygame.quit()


def _load_pygame() -> Any:
    """pygame with its events and joysticks, without a window and without its greeting."""
    for name, value in (
        ("PYGAME_HIDE_SUPPORT_PROMPT", "1"),
        ("SDL_VIDEODRIVER", "dummy"),
        ("SDL_JOYSTICK_ALLOW_BACKGROUND_EVENTS", "1"),
    ):
        os.environ.setdefault(name, value)
    try:
        import pygame
    except ImportError:
        raise MissingPackage("a gamepad needs pygame: pip install 'spiraltrunk[gamepad]'") from None
    pygame.display.init()
    pygame.joystick.init()
    return pygame
