"""``spiraltrunk`` and ``python -m spiraltrunk`` are the command line."""

from __future__ import annotations

import sys


def main() -> int:
    """Run the command line; signals are heard while its modules are still loaded."""
    try:
        from spiraltrunk.cli.signals import end_at_once

        end_at_once()
        from spiraltrunk.cli import main as run

        code = run()
    except KeyboardInterrupt:
        print("spiraltrunk: interrupted", file=sys.stderr)
        code = 130
    if code > 128:
        _end(code)
    return code


def _end(code: int) -> None:
    """End the process as it is: after an interruption, threads of C libraries still run and would crash."""
    import os
    from contextlib import suppress

    for stream in (sys.stdout, sys.stderr):
        with suppress(AttributeError, OSError, ValueError):  # Closed.
            stream.flush()
    os._exit(code)


if __name__ == "__main__":
    sys.exit(main())
