"""Freed memory goes back to the system where the C library can."""

from __future__ import annotations

import platform
import subprocess
import sys

import pytest

SCRIPT = """
import os, sys
from pathlib import Path

def read_mb():
    return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 2**20

if sys.argv[1] == "bound":
    from spiraltrunk.studio.server.heap import bound_heap
    assert bound_heap()
del_first = bytearray(3 * 2**20)
del del_first  # From here on glibc keeps smaller blocks in its heap.
before, large, small = read_mb(), [], []
for _ in range(200):
    large.append(bytearray(2**18))
    small.append(bytearray(600))
full = read_mb()
del large
print(before, full, read_mb())
"""


@pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="the C library is not glibc")
def test_freed_blocks_between_others_go_back_to_the_system():
    kept = {}
    for name in ("as it is", "bound"):
        command = [sys.executable, "-c", SCRIPT, name]
        told = subprocess.run(command, check=True, capture_output=True, text=True).stdout
        before, full, after = map(float, told.split())
        assert full - before > 45.0
        kept[name] = after - before
    assert kept["as it is"] > 25.0, "glibc keeps them otherwise"
    assert kept["bound"] < 3.0
