"""The FR3's driver on the real library and franky-sim's robot, which speaks the robot's protocol over the network.

It enforces no limits and reports no errors, so it says nothing of reflexes.
"""

import importlib.util
import json
import subprocess
import sys
from pathlib import Path

import pytest

MISSING = [name for name in ("franky", "franky_sim") if importlib.util.find_spec(name) is None]


@pytest.mark.skipif(bool(MISSING), reason=f"pip install 'franky-control>=2.0,<3' franky-sim; missing: {MISSING}")
def test_an_fr3_moves_and_holds():
    run = Path(__file__).with_name("franky_sim_run.py")
    done = subprocess.run([sys.executable, str(run)], capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr
    seen = json.loads(done.stdout.splitlines()[-1])
    print(seen)
    assert seen["errors"] == [None] * 4
    # The spring law sags by milliradians.
    assert seen["moved"][3] == pytest.approx(0.05, abs=5e-3)
    assert max(map(abs, seen["moved"][:3] + seen["moved"][4:])) < 5e-3
    assert seen["drift"] < 1e-3
    assert "allowed" in seen["jump"]
    assert seen["fresh"] > 0.0
