"""A kernel that others call through a pointer: compiled in a second process, or where that cannot be in this one."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

MODULE = """
import os, time
from numba import types
from numba.core.typing.templates import signature
from numba.extending import intrinsic
from spiraltrunk.model.jit import compile_shared, compiler
from spiraltrunk.model.shared_kernel import SharedKernel
if "SPIRALTRUNK_COMPILES" in os.environ:
    BEGIN
def third(x):
    return x / 3.0
def sign():
    return signature(types.float64, types.float64)
SHARED = SharedKernel(compile_shared(third, "STAMP"), sign, ("small", "SHARED"))
@intrinsic
def call_third(typing, x):
    return SHARED.sign(), SHARED.generate
@compiler("STAMP", owns_arrays=False, calls=SHARED)
def two_thirds(x):
    return 2.0 * call_third(x)
def tell():
    print(two_thirds(0.7) == 2.0 * (0.7 / 3.0), sum(SHARED._kernel.stats.cache_hits.values()))
"""


def run(folder: Path, program: str = "small.tell()", *, begin: str = "pass", **variables: str) -> str:
    """What a program prints that imports the module; its cache is in the folder."""
    (folder / "small.py").write_text(MODULE.replace("BEGIN", begin))
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(folder / "cache"), "NUMBA_NUM_THREADS": "2", **variables}
    command = [sys.executable, "-c", f"import sys; sys.path.insert(0, {str(folder)!r}); import small; {program}"]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, ""), done.stderr
    return done.stdout


@pytest.mark.slow
def test_second_process_compiles_and_this_one_loads(tmp_path: Path) -> None:
    assert run(tmp_path) == "True 1\n"
    assert run(tmp_path) == "True 1\n"  # Both kernels come from the disc now.


@pytest.mark.parametrize(
    ("program", "variables"),
    [
        ("small.tell()", {"NUMBA_NUM_THREADS": "1"}),
        pytest.param("sys.executable = '/opt/python'; small.tell()", {}, marks=pytest.mark.slow),  # It does not start.
        pytest.param("small.tell()", {"SPIRALTRUNK_COMPILES": "1"}, marks=pytest.mark.slow),
        pytest.param("sys.executable = '/opt/app'; small.tell()", {}, marks=pytest.mark.slow),
        pytest.param("sys.executable = None; small.tell()", {}, marks=pytest.mark.slow),
        pytest.param("sys.frozen = True; small.tell()", {}, marks=pytest.mark.slow),
        pytest.param("small.SHARED._kernel._cache.disable(); small.tell()", {}, marks=pytest.mark.slow),
    ],
)
def test_without_a_second_process_this_one_compiles(tmp_path: Path, program: str, variables: dict[str, str]) -> None:
    assert run(tmp_path, program, **variables) == "True 0\n"


@pytest.mark.parametrize(
    "begin",
    [
        pytest.param(one, marks=pytest.mark.slow)
        for one in ("os.kill(os.getpid(), 9)", "raise ValueError", "os._exit(3)")
    ],
)
def test_where_the_second_process_fails_this_one_compiles(tmp_path: Path, begin: str) -> None:
    assert run(tmp_path, begin=begin) == "True 0\n"


@pytest.mark.slow
def test_second_process_that_hangs_is_given_up(tmp_path: Path) -> None:
    program = "from spiraltrunk.model import shared_kernel; shared_kernel._PATIENCE = 0.1; small.tell()"
    assert run(tmp_path, program, begin="time.sleep(1000)") == "True 0\n"


@pytest.mark.slow
def test_a_script_without_a_guard_runs_once(tmp_path: Path) -> None:
    """A script is not run again by the process that compiles, as `multiprocessing` would."""
    assert run(tmp_path, "print('script'); small.tell()") == "script\nTrue 1\n"


@pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")
def test_second_process_ends_with_its_parent(tmp_path: Path) -> None:
    (tmp_path / "small.py").write_text(MODULE.replace("BEGIN", "pass"))
    program = f"""
import os, sys, threading, time
sys.path.insert(0, {str(tmp_path)!r})
import small
small.SHARED._place = ("slow", "SHARED")
small.SHARED.begin()
print(small.SHARED._process.pid, flush=True)
time.sleep(1000)
"""
    slow = "import time, small\nclass SHARED:\n    serve = staticmethod(lambda parent: (small.SHARED._kernel.py_func, "
    slow += "setattr(small.SHARED._kernel, 'compile', lambda key: time.sleep(1000)), small.SHARED.serve(parent)))\n"
    (tmp_path / "slow.py").write_text(slow)
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path / "cache"), "NUMBA_NUM_THREADS": "2"}
    parent = subprocess.Popen([sys.executable, "-c", program], env=environment, stdout=subprocess.PIPE, text=True)
    assert parent.stdout is not None
    child = Path("/proc") / parent.stdout.readline().strip()
    assert child.exists()
    parent.send_signal(signal.SIGKILL)
    parent.wait()
    parent.stdout.close()
    for _ in range(600):  # A minute, on a machine that is busy.
        if not child.exists() or "\nState:\tZ" in (child / "status").read_text():
            return
        time.sleep(0.1)
    pytest.fail(f"process {child.name} outlives its parent")
