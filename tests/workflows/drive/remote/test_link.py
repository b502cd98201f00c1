"""The robot's process from outside: it starts, tells its state, refuses, and ends with whoever holds its pipe."""

import os
import signal
import threading
import time

import pytest

from spiraltrunk.design import presets
from spiraltrunk.errors import DriveError, RunError
from spiraltrunk.hardware.setup.robot_file import MotorSetup, RobotFile
from spiraltrunk.workflows.drive.remote.link import RobotLink
from spiraltrunk.workflows.drive.remote.requests import Arm, Jog
from spiraltrunk.workflows.drive.remote.setup import RobotSetup


class Heard:
    """What a link told."""

    def __init__(self, **options):
        self.states, self.refusals, self.ends = [], [], []
        self.changed = threading.Condition()
        self.link = RobotLink(
            RobotSetup(design=presets.PAPER, **options),
            on_state=lambda state: self._keep(self.states, state),
            on_refusal=lambda who, text: self._keep(self.refusals, (who, text)),
            on_end=lambda reason: self._keep(self.ends, reason),
        )
        self.link.start()

    def _keep(self, kept, value):
        with self.changed:
            kept.append(value)
            self.changed.notify_all()

    def wait(self, kept, most=60.0):
        end = time.monotonic() + most
        with self.changed:
            while not kept and time.monotonic() < end:
                self.changed.wait(0.1)
        assert kept
        return kept[-1]


class Ended:
    """A process that said its end and left a request unread, as one does that is asked while it ends."""

    def __init__(self, pipe):
        self.pipe = pipe

    def start(self):
        self.pipe.send(("end", None))

    def join(self, _=None):
        pass

    def is_alive(self):
        return False


def test_a_request_that_was_left_unread_is_no_reason():
    ends = []
    ignore = lambda *_: None  # noqa: E731
    link = RobotLink(RobotSetup(design=presets.PAPER), on_state=ignore, on_refusal=ignore, on_end=ends.append)
    link._process = Ended(link._theirs)
    link.close()  # Asks for the end, which nobody reads.
    link.start()
    link.join()
    assert ends == [None]


class Speaking(Ended):
    """A process that tells a state and then waits."""

    def start(self):
        self.pipe.send(("state", "armed"))


@pytest.mark.filterwarnings("error::pytest.PytestUnhandledThreadExceptionWarning")
def test_a_listener_that_fails_ends_the_link_with_the_reason():
    ends, ignore = [], lambda *_: None

    def fail(state):
        raise ZeroDivisionError("no picture")

    link = RobotLink(RobotSetup(design=presets.PAPER), on_state=fail, on_refusal=ignore, on_end=ends.append)
    link._process = Speaking(link._theirs)
    link.start()
    link.join()
    assert ends == ["ZeroDivisionError: no picture"]
    with pytest.raises(RunError, match="not connected"):
        link.ask(Arm())


def test_a_robot_is_told_and_closed():
    heard = Heard()
    state = heard.wait(heard.states)
    assert state.is_twin
    assert state.frames.shape == (presets.PAPER.n_section, 4, 4)
    with pytest.raises(DriveError):
        heard.link.ask(Jog(0, 9999.0), "me")
    heard.link.ask(Arm(), "me")
    who, text = heard.wait(heard.refusals)
    assert who == "me"
    assert "no page in control answers" in text
    heard.link.close()
    heard.link.join(60.0)
    assert heard.wait(heard.ends) is None
    assert heard.link._process.exitcode == 0
    with pytest.raises(RunError):
        heard.link.ask(Arm())
    heard.link.close()


@pytest.mark.slow
def test_a_process_ends_with_the_other_end_of_its_pipe_and_by_a_signal():
    cut, killed = Heard(), Heard()
    cut.wait(cut.states)
    killed.wait(killed.states)
    cut.link._ours.send("no request at all")
    os.kill(killed.link._process.pid, signal.SIGTERM)
    for heard in (cut, killed):
        heard.link.join(60.0)
        heard.wait(heard.ends)
        assert heard.link._process.exitcode == 0


@pytest.mark.slow
def test_a_robot_whose_port_cannot_be_opened_tells_why():
    motors = MotorSetup(family="gm6020", ids=(1, 2, 3))
    heard = Heard(file=RobotFile(name="mine", bus="board:/dev/no-such-port", motors=motors))
    assert "no-such-port" in heard.wait(heard.ends)
    assert not heard.states
