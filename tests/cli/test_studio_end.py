"""How the command that opens the browser page ends: whatever fails, the next thing is done."""

import tempfile
from argparse import Namespace
from types import SimpleNamespace

import pytest

pytest.importorskip("viser", reason="viser is not installed")

from spiraltrunk.cli.verbs import studio as verb
from spiraltrunk.studio import studio as server
from spiraltrunk.studio import tabs
from spiraltrunk.studio.page import scratch
from spiraltrunk.studio.robot import hub
from spiraltrunk.studio.server import heap

ARGUMENTS = Namespace(
    design="paper", robot=None, without_watchdog=False, host="127.0.0.1", port=0, no_browser=True, json=False
)


@pytest.fixture
def ended(tmp_path, monkeypatch):
    """What was ended, in its order, of a studio with a robot and a temporary folder that a person interrupts."""
    order = []

    class Studio:
        address, needs_token = "http://127.0.0.1:1/", False

        def __init__(self, design, load_tabs, options):
            load_tabs()
            scratch.make_scratch("job")

        def stop(self):
            order.append("studio")
            raise RuntimeError("it does not stop")

    class Hub:
        def __init__(self, *_, **__):
            pass

        def close(self):
            order.append("robot")

    def interrupt():
        raise KeyboardInterrupt

    monkeypatch.setattr(scratch, "_roots", [])
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    monkeypatch.setattr(heap, "bound_heap", lambda: None)
    monkeypatch.setattr(server, "Studio", Studio)
    monkeypatch.setattr(hub, "RobotHub", Hub)
    monkeypatch.setattr(tabs, "build_tabs", lambda open_hub: open_hub())
    waiting = SimpleNamespace(Lock=verb.threading.Lock, Event=lambda: SimpleNamespace(wait=interrupt))
    monkeypatch.setattr(verb, "threading", waiting)
    with pytest.raises(RuntimeError, match="does not stop"):
        verb._run(ARGUMENTS)
    return order


def test_the_temporary_folder_is_removed(ended, tmp_path):
    """Exit handlers do not run: an interrupted command ends by `os._exit`."""
    assert list(tmp_path.iterdir()) == []


def test_the_robot_is_let_go_before_the_pages_are_closed(ended):
    assert ended == ["robot", "studio", "robot"]
