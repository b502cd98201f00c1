"""Who waits for a model to be compiled is told so, once."""

from __future__ import annotations

import subprocess
import sys

COMPILES = """
from spiraltrunk.cli import main
main(["--version"])
import spiraltrunk.model.jit
from numba import njit
for power in (2, 3):
    law = njit(lambda x: x**power)
    law(1.0), law(2.0)
"""


def test_compiling_is_told_once() -> None:
    done = subprocess.run([sys.executable, "-c", COMPILES], capture_output=True, text=True, check=True)
    assert done.stderr.startswith("spiraltrunk: compiling the models, once")
    assert done.stderr.count("\n") == 1


def test_a_library_says_nothing_of_itself() -> None:
    code = COMPILES.replace('main(["--version"])', "")
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stderr == ""
