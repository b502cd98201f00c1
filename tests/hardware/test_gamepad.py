"""A gamepad's sticks as speeds of cables; a device that is simulated."""

import math
import sys
import types

import pytest
from hypothesis import given
from hypothesis import strategies as st

from spiraltrunk.errors import DesignError, DriveError, MissingPackage
from spiraltrunk.hardware.gamepad import Gamepad, GamepadInput, GamepadSettings, init_jog, step_jog

DIRECTIONS = tuple((math.cos(a), math.sin(a)) for a in (math.pi / 2, math.pi * 7 / 6, math.pi * 11 / 6))
SETTINGS = GamepadSettings(directions=DIRECTIONS)
DT = 0.02


def see(x=0.0, y=0.0, tighten=0.0, pressed=(), *, is_connected=True):
    return GamepadInput(is_connected, (x, y, 0.0, tighten), tuple(i in pressed for i in range(12)))


def hold(seen, seconds=2.0, state=None):
    state = step_jog(SETTINGS, init_jog(SETTINGS), see(), DT) if state is None else state
    for _ in range(round(seconds / DT)):
        state = step_jog(SETTINGS, state, seen, DT)
    return state


def test_a_stick_bends_towards_where_it_is_pushed():
    """Up is the direction of cable 0: it is pulled, the others give half as much, and their sum is zero."""
    speeds = hold(see(y=-1.0)).speeds
    assert speeds == pytest.approx((SETTINGS.speed_slow, -0.5 * SETTINGS.speed_slow, -0.5 * SETTINGS.speed_slow))


def test_tightening_pulls_all_and_fast_is_faster():
    assert hold(see(tighten=1.0)).speeds == pytest.approx((SETTINGS.speed_slow,) * 3)
    assert hold(see(tighten=-1.0, pressed={5})).speeds == pytest.approx((-SETTINGS.speed_fast,) * 3)


def test_no_speed_beyond_the_fastest_with_both_sticks():
    assert hold(see(y=-1.0, tighten=1.0)).speeds[0] == pytest.approx(SETTINGS.speed_slow)


def test_dead_zone_is_round_and_has_no_step_at_its_edge():
    assert hold(see(x=0.1, y=0.1)).speeds == (0.0, 0.0, 0.0)
    edge = hold(see(y=-0.151)).speeds[0]
    assert 0.0 < edge < 0.01 * SETTINGS.speed_slow


def test_speeds_change_no_faster_than_allowed():
    state, before = hold(see()), (0.0,) * 3
    for seen in [see(tighten=1.0, pressed={5})] * 5 + [see(tighten=-1.0, pressed={5})] * 40:
        state = step_jog(SETTINGS, state, seen, DT)
        for old, new in zip(before, state.speeds, strict=True):
            assert abs(new - old) <= SETTINGS.acceleration * DT + 1e-12
        before = state.speeds


@pytest.mark.parametrize(
    ("seen", "text"),
    [
        (see(y=-1.0, pressed={1}), "stop button"),
        (see(is_connected=False), "gone"),
        (GamepadInput(True, (), ()), "0 axes"),
        (see(x=math.nan), "beyond"),
        (see(tighten=3.0), "beyond"),
    ],
)
def test_stops_are_at_once_and_last_until_the_sticks_were_in_their_middle(seen, text):
    moving = hold(see(y=-1.0))
    stopped = step_jog(SETTINGS, moving, seen, DT)
    assert text in stopped.stop
    assert stopped.speeds == (0.0, 0.0, 0.0)
    held = hold(see(y=-1.0), state=stopped)
    assert held.speeds == (0.0, 0.0, 0.0)
    assert held.stop == ""
    again = hold(see(y=-1.0), state=step_jog(SETTINGS, held, see(), DT))
    assert again.speeds[0] > 0.0


def test_a_stick_that_is_held_at_the_start_moves_nothing():
    assert hold(see(y=-1.0), state=init_jog(SETTINGS)).speeds == (0.0, 0.0, 0.0)


def test_a_loop_that_hung_stops():
    assert step_jog(SETTINGS, hold(see(y=-1.0)), see(y=-1.0), 5.0).stop


@given(st.lists(st.tuples(st.floats(), st.floats(), st.floats(), st.sets(st.integers(0, 11))), max_size=20))
def test_whatever_it_reports_speeds_are_finite_and_limited(reports):
    state = init_jog(SETTINGS)
    for x, y, tighten, pressed in reports:
        state = step_jog(SETTINGS, state, see(x, y, tighten, pressed), DT)
        assert all(abs(speed) <= SETTINGS.speed_fast for speed in state.speeds)


@pytest.mark.parametrize(
    "changes", [{"directions": ()}, {"directions": ((1.0, 1.0),)}, {"speed_fast": 0.001}, {"stop_button": -1}]
)
def test_settings_that_are_refused(changes):
    with pytest.raises(DesignError):
        GamepadSettings(**({"directions": DIRECTIONS} | changes))


class FakeDevice:
    is_broken = False

    def __init__(self, index):
        self.index = index

    def get_name(self):
        return f"Pad {self.index}"

    def get_instance_id(self):
        return 40 + self.index

    def get_numaxes(self):
        return 4

    def get_numbuttons(self):
        return 12

    def get_axis(self, axis):
        if FakeDevice.is_broken:
            raise OSError("joystick not initialized")
        return 0.1 * axis

    def get_button(self, button):
        return button == 5


@pytest.fixture
def pygame(monkeypatch):
    """What of pygame is used."""
    removed = []
    fake = types.SimpleNamespace(
        JOYDEVICEREMOVED=1,
        error=OSError,
        display=types.SimpleNamespace(init=lambda: None),
        joystick=types.SimpleNamespace(init=lambda: None, get_count=lambda: 2, Joystick=FakeDevice),
        event=types.SimpleNamespace(get=lambda kind: removed, clear=lambda: None),
        quit=lambda: None,
        removed=removed,
    )
    monkeypatch.setitem(sys.modules, "pygame", fake)
    for name in ("PYGAME_HIDE_SUPPORT_PROMPT", "SDL_VIDEODRIVER", "SDL_JOYSTICK_ALLOW_BACKGROUND_EVENTS"):
        monkeypatch.setenv(name, "dummy")  # Restored afterwards.
    return fake


def test_a_device_is_read(pygame):
    with Gamepad(1) as gamepad:
        seen = gamepad.read()
    assert seen.is_connected
    assert seen.axes == pytest.approx((0.0, 0.1, 0.2, 0.3))
    assert [i for i, pressed in enumerate(seen.buttons) if pressed] == [5]
    assert not gamepad.read().is_connected


def test_a_device_that_is_unplugged_stays_gone(pygame):
    gamepad = Gamepad(0)
    pygame.removed.append(types.SimpleNamespace(instance_id=41))
    assert gamepad.read().is_connected  # Another one.
    pygame.removed.append(types.SimpleNamespace(instance_id=40))
    assert not gamepad.read().is_connected
    pygame.removed.clear()
    assert not gamepad.read().is_connected


def test_a_device_that_fails_is_gone(pygame, monkeypatch):
    gamepad = Gamepad(0)
    monkeypatch.setattr(FakeDevice, "is_broken", True)
    assert not gamepad.read().is_connected


def test_a_number_that_is_not_there(pygame):
    with pytest.raises(DriveError, match=r"no gamepad 2; found: 0 \(Pad 0\), 1 \(Pad 1\)"):
        Gamepad(2)


def test_without_pygame(monkeypatch):
    monkeypatch.setitem(sys.modules, "pygame", None)
    for name in ("PYGAME_HIDE_SUPPORT_PROMPT", "SDL_VIDEODRIVER", "SDL_JOYSTICK_ALLOW_BACKGROUND_EVENTS"):
        monkeypatch.setenv(name, "dummy")
    with pytest.raises(MissingPackage, match=r"pip install 'spiraltrunk\[gamepad\]'"):
        Gamepad()
