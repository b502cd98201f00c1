"""``python -m spiraltrunk`` is the command line."""

import sys

from spiraltrunk.cli import main

if __name__ == "__main__":
    sys.exit(main())
