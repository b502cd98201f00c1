"""Mutation test of the safety layer: how many changed operators its own fast tests notice.

Claim: of the mutants of `spiraltrunk.hardware.safety`, 90 % are noticed by ``tests/hardware/safety`` alone.
Mutants and rules are those of `mutants`, beside this file.
"""

from __future__ import annotations

import sys
from pathlib import Path

from mutants import PACKAGE, ROOT, build_parser, draw, examine_sample, find_mutants

SAFETY = PACKAGE / "hardware" / "safety"
TESTS = str(Path("tests") / "hardware" / "safety")


def main() -> int:
    """Examine a sample of the safety layer, or all of it."""
    parser = build_parser(__doc__.partition("\n")[0], 120, "out/mutants_safety.jsonl")
    parser.set_defaults(jobs=1, limit_s=300.0, near_only=True)
    parser.add_argument("--below", default=".", metavar="FOLDER", help='of the safety layer, such as "watches"')
    options = parser.parse_args()
    drawn = SAFETY / options.below
    total = sum(1 for file in sorted((ROOT / drawn).rglob("*.py")) for _ in find_mutants(file))
    print(f"{total} mutants in all")
    tests = [TESTS]
    if options.below != ".":  # Those of the folder first.
        tests = [f"{TESTS}/{options.below}", *sorted(f"{TESTS}/{one.name}" for one in (ROOT / TESTS).glob("test_*.py"))]
    return examine_sample(draw(min(options.count, total), options.seed, drawn), options, [TESTS], tests)


if __name__ == "__main__":
    sys.exit(main())
