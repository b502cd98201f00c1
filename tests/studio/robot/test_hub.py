"""The robot of a studio: one page at most is in control, and one that is gone leaves no torque."""

import threading
import time
from types import SimpleNamespace

import pytest

pytest.importorskip("viser", reason="viser is not installed")

from spiraltrunk.design import presets
from spiraltrunk.errors import DriveError, RunError, StudioError
from spiraltrunk.hardware.safety.states import Mode
from spiraltrunk.hardware.setup.robot_file import MotorSetup, RobotFile
from spiraltrunk.studio.robot import hub as hub_module
from spiraltrunk.studio.robot.hub import RobotHub
from spiraltrunk.workflows.drive.remote.requests import Alive, Arm, Clear, Home, Jog, Leave, Stop, check_request

DESIGN = presets.PAPER
OFF = 1e-3
"""Electric torque below which a motor counts as without torque [N m]."""


class FakeLink:
    """A link that keeps what it is asked."""

    def __init__(self, setup, *, on_state, on_refusal, on_end):
        self.setup, self.asked = setup, []
        self.on_state, self.on_refusal, self.on_end = on_state, on_refusal, on_end

    def start(self):
        pass

    def ask(self, request, asker=""):
        check_request(self.setup.design, request)
        self.asked.append(request)

    def close(self):
        self.on_end(None)

    def join(self):
        pass


class FakePage:
    """A page whose browser answers as long as the test says so."""

    def __init__(self, hub, name):
        self.hub, self.name, self.answers = hub, name, True
        self.shown, self.n_update = [], 0
        hub.enter(self)

    def ask_beat(self):
        if self.answers:
            self.hub.take_beat(self, time.monotonic())

    def update(self):
        self.n_update += 1

    def show_message(self, text):
        self.shown.append(text)


@pytest.fixture
def hub(monkeypatch):
    monkeypatch.setattr(hub_module, "RobotLink", FakeLink)
    one = RobotHub(DESIGN)
    yield one
    one.close()


def test_one_page_is_in_control_and_others_watch_and_stop(hub):
    first, second = FakePage(hub, "page 1"), FakePage(hub, "page 2")
    hub.connect(first, "twin", DESIGN)
    link = hub._link
    for act in (
        lambda: hub.ask(second, Jog(0, 0.001)),
        lambda: hub.take(second),
        lambda: hub.disconnect(second),
        lambda: hub.connect(second, "twin", DESIGN),
    ):
        with pytest.raises(StudioError):
            act()
    hub.take_beat(second, 1.0)
    assert not [one for one in link.asked if isinstance(one, Jog) or one == Alive(1.0)]
    assert hub.is_owner(first)
    assert hub.owner == "page 1"
    hub.stop()
    assert Stop() in link.asked
    assert second.n_update >= 1
    hub.release(second)
    assert hub.owner == "page 1"


def test_a_page_that_leaves_gives_the_robot_back_safe(hub):
    first, second = FakePage(hub, "page 1"), FakePage(hub, "page 2")
    hub.connect(first, "twin", DESIGN)
    hub.leave(first)
    hub.leave(first)
    assert [one for one in hub._link.asked if one == Leave()] == [Leave()]
    assert hub.owner == ""
    with pytest.raises(StudioError, match="no page is in control"):
        hub.ask(first, Arm())
    hub.take(second)
    hub.ask(second, Jog(0, 0.001))
    assert Jog(0, 0.001) in hub._link.asked


def test_two_pages_that_grab_at_once_do_not_both_get_it(hub):
    pages = [FakePage(hub, f"page {i}") for i in range(8)]
    hub.connect(pages[0], "twin", DESIGN)
    hub.release(pages[0])
    begin, got = threading.Barrier(len(pages)), []

    def grab(page):
        begin.wait()
        try:
            hub.take(page)
            got.append(page)
        except StudioError:
            pass

    threads = [threading.Thread(target=grab, args=(page,)) for page in pages]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(got) == 1
    assert hub.is_owner(got[0])


def test_a_refusal_is_told_to_the_page_that_asked(hub):
    first, second = FakePage(hub, "page 1"), FakePage(hub, "page 2")
    hub.connect(first, "twin", DESIGN)
    hub._link.on_refusal("page 1", "no")
    assert first.shown == ["no"]
    assert second.shown == []


def test_a_process_that_ends_is_told_to_all(hub):
    first, second = FakePage(hub, "page 1"), FakePage(hub, "page 2")
    hub.connect(first, "twin", DESIGN)
    hub._link.on_end("the bus is gone")
    assert not hub.is_connected
    assert hub.owner == ""
    assert [page.shown for page in (first, second)] == [["the robot is disconnected: the bus is gone"]] * 2
    with pytest.raises(RunError):
        hub.stop()
    with pytest.raises(RunError):
        hub.ask(first, Arm())


def test_values_out_of_their_range_are_not_sent(hub):
    page = FakePage(hub, "page 1")
    hub.connect(page, "twin", DESIGN)
    for way in (9999.0, float("nan"), "5"):
        with pytest.raises(DriveError):
            hub.ask(page, Jog(0, way))
    assert not [one for one in hub._link.asked if isinstance(one, Jog)]


def test_states_of_another_clock_are_not_drawn_with_those_before(hub):
    page = FakePage(hub, "page 1")
    hub.connect(page, "twin", DESIGN)

    def tell(moment, run=""):
        hub._link.on_state(SimpleNamespace(snapshot=SimpleNamespace(time=moment), run=run))
        return [state.snapshot.time for state in hub.states]

    tell(5.0)
    assert tell(5.1) == [5.0, 5.1]
    assert tell(0.1, "reach") == [0.1], "a strategy has a twin of its own, with a clock of its own"
    assert tell(0.2, "reach") == [0.1, 0.2]
    assert tell(5.2) == [5.2], "after it the twin before goes on, later by its own clock"
    assert tell(5.3) == [5.2, 5.3]


def test_only_the_robot_of_the_command_line_can_be_connected(monkeypatch):
    monkeypatch.setattr(hub_module, "RobotLink", FakeLink)
    alone = RobotHub(DESIGN)
    assert alone.robots == ("twin",)
    page = FakePage(alone, "page 1")
    for name in ("robot", "board:/dev/ttyACM0", "", "../robot.toml"):
        with pytest.raises(StudioError, match="allowed: twin"):
            alone.connect(page, name, DESIGN)
    motors = MotorSetup(family="gm6020", ids=(1, 2, 3))
    file = RobotFile(name="mine", bus="board:/dev/no-such-port", motors=motors)
    wired = RobotHub(DESIGN, file)
    assert wired.robots == ("twin", "mine on board:/dev/no-such-port")
    page = FakePage(wired, "page 1")
    wired.connect(page, wired.robots[1], presets.PAPER)
    assert wired.setup.file is file
    wired.close()


def connect_twin(pace):
    """A hub whose twin is connected, its page, and ``wait(holds)``, which waits for a state."""
    hub = RobotHub(DESIGN, pace=pace)
    page = FakePage(hub, "page 1")

    def wait(holds):
        end = time.monotonic() + 120.0
        while not (hub.state is not None and holds(hub.state)) and time.monotonic() < end:
            time.sleep(0.02)
        assert holds(hub.state)

    hub.connect(page, "twin", DESIGN)
    wait(lambda state: state.snapshot.cables[0].temperature > 0.0)
    return hub, page, wait


def test_stop_while_homing_leaves_no_torque_and_no_homed_robot():
    hub, page, wait = connect_twin(pace=1.0)
    hub.ask(page, Home())
    wait(lambda state: state.snapshot.mode is Mode.HOMING and max(map(abs, state.true_torques)) > OFF)
    hub.stop()
    wait(lambda state: state.snapshot.mode is Mode.FAULT and max(map(abs, state.true_torques)) < OFF)
    assert not hub.state.snapshot.is_homed
    hub.ask(page, Clear("page 1"))
    wait(lambda state: state.snapshot.mode is Mode.SAFE)
    hub.ask(page, Arm())
    end = time.monotonic() + 60.0
    while not page.shown and time.monotonic() < end:
        time.sleep(0.02)
    assert "not homed" in page.shown[0]
    assert hub.state.snapshot.mode is Mode.SAFE
    hub.close()


@pytest.mark.slow
def test_a_page_that_does_not_answer_loses_the_true_torque_of_the_twin():
    hub, page, wait = connect_twin(pace=20.0)
    hub.ask(page, Home())
    wait(lambda state: state.snapshot.is_homed)
    hub.ask(page, Arm())
    wait(lambda state: max(state.true_torques) > 0.02)
    page.answers = False
    wait(lambda state: state.snapshot.mode is Mode.SAFE)
    wait(lambda state: max(map(abs, state.true_torques)) < OFF)
    assert "did not answer" in hub.state.note
    hub.close()
    assert not hub.is_connected
