"""The suite's modules, which tests of other folders find in the same way."""

import sys
from pathlib import Path

SUITE = str(Path(__file__).parent / "suite")
if SUITE not in sys.path:
    sys.path.insert(0, SUITE)
