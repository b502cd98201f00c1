"""``spiraltrunk`` and ``python -m spiraltrunk`` are the command line."""

from __future__ import annotations

import sys


def main() -> int:
    """Run the command line; Ctrl-C is heard while its modules are still loaded."""
    try:
        from spiraltrunk.cli import main as run

        return run()
    except KeyboardInterrupt:
        print("spiraltrunk: interrupted", file=sys.stderr)
        return 130


if __name__ == "__main__":
    sys.exit(main())
