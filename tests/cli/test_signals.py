"""A command that is killed while it works leaves its folder as it was, says so in one line, and no process stays."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

ENDS = {
    signal.SIGTERM: (143, "spiraltrunk: terminated"),
    signal.SIGHUP: (129, "spiraltrunk: hung up"),
    signal.SIGINT: (130, "spiraltrunk: interrupted"),
}
"""Exit code and last line of each signal."""

SLOW_WRITE = """
import os, sys, time
from spiraltrunk import cli
def wait(file):
    print("writing", file=sys.stderr, flush=True)
    time.sleep(30)
os.fsync = wait
sys.exit(cli.main(["design", "--out", sys.argv[1] + "/new/trunk.toml"]))
"""
"""The verb, held where its draft is written and not yet in place."""

SLOWER_WRITE = SLOW_WRITE.replace(
    "    time.sleep(30)",
    """    time.sleep(1)
    print("still writing", file=sys.stderr, flush=True)
    time.sleep(30)""",
)
"""The same, which says once more that it goes on."""

MODULE = [sys.executable, "-m", "spiraltrunk"]


def start(*command: str) -> subprocess.Popen[str]:
    """Begin the command with all signals heard, also where the tests run in the background or under nohup."""
    pipe = subprocess.PIPE
    before = {number: signal.signal(number, signal.SIG_DFL) for number in ENDS}
    try:
        return subprocess.Popen(command, stdout=pipe, stderr=pipe, text=True, start_new_session=True)
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def wait_for(running: subprocess.Popen[str], line: str) -> None:
    assert running.stderr is not None
    for said in running.stderr:
        if said.strip() == line:
            return
    raise AssertionError(f"{line} was never said")


def is_gone(group: int, patience: float = 10.0) -> bool:
    end = time.monotonic() + patience
    while time.monotonic() < end:
        try:
            os.killpg(group, 0)
        except ProcessLookupError:
            return True
        time.sleep(0.05)
    return False


@pytest.fixture
def out(tmp_path: Path) -> Path:
    (tmp_path / "notes.txt").write_text("mine")
    return tmp_path


def assert_ended(running: subprocess.Popen[str], number: signal.Signals, out: Path) -> None:
    printed, said = running.communicate(timeout=240)
    code, line = ENDS[number]
    assert running.returncode == code, said
    assert printed == ""
    assert said.splitlines() == [line]
    assert [path.name for path in out.iterdir()] == ["notes.txt"]
    assert (out / "notes.txt").read_text() == "mine"
    assert is_gone(running.pid)


@pytest.mark.parametrize(
    "number",
    [signal.SIGHUP, *(pytest.param(number, marks=pytest.mark.slow) for number in (signal.SIGTERM, signal.SIGINT))],
)
def test_grasp(number: signal.Signals, out: Path) -> None:
    running = start(*MODULE, "grasp", "--no-video", "--out", str(out))
    wait_for(running, "spiraltrunk: reach")
    assert len(list(out.iterdir())) == 2, "no draft is there yet"
    running.send_signal(number)
    assert_ended(running, number, out)


SLOW_MJCF = """
<mujoco>
  <compiler><lengthrange inttotal="100" timestep="1e-9"/></compiler>
  <worldbody><body><joint name="j" range="-1 1"/><geom size=".03"/></body></worldbody>
  <actuator><muscle joint="j"/></actuator>
</mujoco>
"""
"""A file that MuJoCo would compile for hours, simulating the muscle's length range."""


def test_while_a_file_of_the_user_is_compiled(out: Path, tmp_path_factory: pytest.TempPathFactory) -> None:
    path = tmp_path_factory.mktemp("object") / "object.xml"
    path.write_text(SLOW_MJCF)
    running = start(*MODULE, "grasp", "--no-video", "--object", f"mjcf:path={path}", "--out", str(out))
    children = Path(f"/proc/{running.pid}/task/{running.pid}/children")
    end = time.monotonic() + 60
    while not children.read_text() and time.monotonic() < end:
        time.sleep(0.02)
    assert children.read_text(), "no process was started"
    running.send_signal(signal.SIGINT)
    assert_ended(running, signal.SIGINT, out)


@pytest.mark.slow
def test_bench(out: Path) -> None:
    running = start(*MODULE, "bench", "--out", str(out))
    wait_for(running, "spiraltrunk: grasp_real_time")
    running.terminate()
    assert_ended(running, signal.SIGTERM, out)


LOST_IN_C = """
import functools, signal, sys
import mujoco
from spiraltrunk.cli.signals import run_interruptibly
class Number:
    __float__ = functools.partial(signal.raise_signal, signal.SIGTERM)
def work():
    mujoco.MjSpec().visual.headlight.ambient = [Number()] * 3
    return 0
sys.exit(run_interruptibly(work))
"""
"""A signal while MuJoCo converts an argument: it replaces the exception by a TypeError of its own."""


def test_an_exception_that_c_code_replaces(out: Path) -> None:
    assert_ended(start(sys.executable, "-c", LOST_IN_C), signal.SIGTERM, out)


def test_design(out: Path) -> None:
    running = start(sys.executable, "-c", SLOW_WRITE, str(out))
    wait_for(running, "writing")
    assert len(list((out / "new").iterdir())) == 1, "no draft is there yet"
    running.terminate()
    assert_ended(running, signal.SIGTERM, out)


@pytest.mark.slow
def test_a_signal_to_process_and_group_is_one(out: Path) -> None:
    """As the command ``timeout`` sends it."""
    running = start(sys.executable, "-c", SLOW_WRITE, str(out))
    wait_for(running, "writing")
    running.terminate()
    os.killpg(running.pid, signal.SIGTERM)
    assert_ended(running, signal.SIGTERM, out)


@pytest.mark.slow
def test_without_hang_up_it_goes_on(out: Path) -> None:
    """As the command ``nohup`` starts it."""
    deaf = ("sh", "-c", "trap '' HUP; exec \"$@\"", "sh")
    running = start(*deaf, sys.executable, "-c", SLOWER_WRITE, str(out))
    wait_for(running, "writing")
    running.send_signal(signal.SIGHUP)
    wait_for(running, "still writing")
    running.terminate()
    assert_ended(running, signal.SIGTERM, out)


@pytest.mark.gl
@pytest.mark.slow
def test_while_the_video_is_drawn(out: Path) -> None:
    running = start(*MODULE, "grasp", "--out", str(out))
    try:
        wait_for(running, "spiraltrunk: video")
    except AssertionError:
        pytest.skip("no OpenGL here")
    running.terminate()
    assert_ended(running, signal.SIGTERM, out)


WHILE_LOADING = """
import sys
class Stop:
    def find_spec(self, name, path=None, target=None):
        if name == "spiraltrunk.cli":
            raise KeyboardInterrupt
sys.meta_path.insert(0, Stop())
from spiraltrunk.__main__ import main
sys.exit(main())
"""
"""Ctrl-C that comes before the command line is there."""


def test_ctrl_c_while_modules_are_loaded_is_one_line() -> None:
    done = subprocess.run([sys.executable, "-c", WHILE_LOADING], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (130, "spiraltrunk: interrupted\n")


def run(program: str, tmp_path: Path) -> str:
    """What a program of this package's says whose function ``command`` is interrupted; it ends as by SIGTERM."""
    (tmp_path / "other.py").write_text(OTHER)
    tail = (
        "from spiraltrunk.cli.signals import run_interruptibly; code = run_interruptibly(command); print('code', code)"
    )
    path = os.pathsep.join([str(tmp_path), *sys.path])
    done = subprocess.run(
        [sys.executable, "-c", f"{program}\n{tail}"], capture_output=True, text=True, check=True,
        env=os.environ | {"PYTHONPATH": path},
    )  # fmt: skip
    assert done.stderr == "spiraltrunk: terminated\n"
    printed, _, code = done.stdout.rpartition("code ")
    assert code == "143\n"
    return printed.replace("\n", " ").strip()


OTHER = """
import os, signal
def interrupt():
    os.kill(os.getpid(), signal.SIGTERM)
    print("whole")
SOURCE = '''
import os, signal
def typeof_pyval():
    os.kill(os.getpid(), signal.SIGTERM)
    print("whole")
def _compile_for_args():
    typeof_pyval()
'''
"""
"""A module that cannot be left at any moment."""

AT_ONCE = """
import os, signal
def command():
    os.kill(os.getpid(), signal.SIGTERM); print("not here")
"""

IN_OTHER_CODE = """
import other
def command():
    other.interrupt()
    print("not here")
"""

BEHIND_OTHER_CODE = """
import os, signal
import other
def command():
    other.call = lambda: inner()
    exec("def pass_on(): call()", vars(other))
    other.pass_on()
    print("not here")
def inner():
    os.kill(os.getpid(), signal.SIGTERM)
    print("whole")
"""

IN_AN_IMPORT = """
import sys, os
from pathlib import Path
import other
(Path(other.__file__).parent / "late.py").write_text("import other; other.interrupt()")
def command():
    import late
    print("not here")
"""

ENTERING_A_CONTEXT = """
import os, signal
from contextlib import contextmanager
@contextmanager
def opened():
    os.kill(os.getpid(), signal.SIGTERM)
    print("opened")
    try:
        yield
    finally:
        print("closed")
def command():
    with opened():
        print("not here")
"""

IN_NUMBA = """
import other
exec(other.SOURCE, numba := {"__name__": "numba.core.typing"})
def command():
    numba["typeof_pyval"]()
    print("not here")
"""

COMPILING = IN_NUMBA.replace("typeof_pyval", "_compile_for_args")

IN_A_DESTRUCTOR = """
import os, signal
class Destroyed:
    def __del__(self):
        os.kill(os.getpid(), signal.SIGTERM)
        print("not here")
def command():
    Destroyed()
    print("not here")
"""

IN_AN_ERROR = """
import other
def command():
    try:
        raise ValueError
    except ValueError:
        other.interrupt()
        print("not here")
"""

MOMENTS = {
    "at once": (AT_ONCE, ""),
    "in other code": (IN_OTHER_CODE, "whole"),
    "called by other code": (BEHIND_OTHER_CODE, "whole"),
    "in an import": (IN_AN_IMPORT, "whole"),
    "entering a context": (ENTERING_A_CONTEXT, "opened closed"),
    "in Numba, called by compiled code": (IN_NUMBA, "whole"),
    "in Numba, compiling": (COMPILING, ""),
    "in a destructor": (IN_A_DESTRUCTOR, ""),
    "in an error": (IN_AN_ERROR, "whole"),
}
"""Programs, and what they still do after the signal."""


@pytest.mark.parametrize("moment", MOMENTS)
def test_a_command_is_left_where_it_can_be(moment: str, tmp_path: Path) -> None:
    program, still_done = MOMENTS[moment]
    assert run(program, tmp_path) == still_done


TWICE = """
import sys, time
from spiraltrunk.cli import signals
signals._REPEAT_TIME = 0.0
def command():
    print("held", flush=True)
    while True:
        time.sleep(600)
exec("def hold(): command()", other := {"command": command, "__name__": "other"})
print(signals.run_interruptibly(other["hold"]))
"""
"""A command that stays in code that cannot be left."""


def test_a_second_signal_ends_what_the_first_did_not() -> None:
    running = start(sys.executable, "-c", TWICE)
    assert running.stdout is not None
    assert running.stdout.readline() == "held\n"
    running.terminate()
    while running.poll() is None:
        running.terminate()
        time.sleep(0.05)
    assert running.returncode == 143
    assert running.communicate() == ("", "")


BEFORE = """
import os, signal, sys
class Stop:
    def find_spec(self, name, path=None, target=None):
        if name == "spiraltrunk.cli.entry":
            os.kill(os.getpid(), signal.SIGTERM)
sys.meta_path.insert(0, Stop())
from spiraltrunk.__main__ import main
sys.exit(main())
"""


def test_a_signal_while_modules_are_loaded_is_one_line() -> None:
    done = subprocess.run([sys.executable, "-c", BEFORE], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (143, "spiraltrunk: terminated\n")
