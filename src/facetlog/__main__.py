"""Where the program starts: `facetlog` and `python -m facetlog`."""

import sys
from typing import NoReturn

__all__ = ["INTERRUPTED", "run"]

INTERRUPTED = 130  # 128 + the signal's number


def run() -> NoReturn:
    """Runs the command line; Ctrl-C ends it quietly even while it is still being loaded."""
    try:
        from facetlog.cli import main

        sys.exit(main(sys.argv[1:]))
    except KeyboardInterrupt:
        sys.exit(INTERRUPTED)


if __name__ == "__main__":
    run()
