"""Where the program starts: `facetlog` and `python -m facetlog`."""

import atexit
import os
import signal
import sys
from typing import NoReturn

from facetlog.one_thread import ONE_THREAD

__all__ = ["INTERRUPTED", "run"]

INTERRUPTED = 130  # 128 + the signal's number


def run() -> NoReturn:
    """Runs the command line; Ctrl-C ends it quietly even while it is still being loaded."""
    for name in ONE_THREAD:
        os.environ.setdefault(name, "1")
    try:
        from facetlog.cli import main

        code = main(sys.argv[1:])
    except KeyboardInterrupt:
        code = INTERRUPTED
    # Before all else that is done at the end: another Ctrl-C would end that in the middle, with a
    # traceback.
    atexit.register(signal.signal, signal.SIGINT, signal.SIG_IGN)
    sys.exit(code)


if __name__ == "__main__":
    run()
