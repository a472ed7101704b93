"""Entry point of `facetlog` and `python -m facetlog`.

Nothing is loaded before Ctrl-C is looked after: what Python itself does before is a traceback.
"""

import sys

TYPE_CHECKING = False  # typing takes longer to load than all the rest
if TYPE_CHECKING:
    from typing import NoReturn

__all__ = ["INTERRUPTED", "run"]

INTERRUPTED = 130  # 128 + the signal's number


def run() -> "NoReturn":
    """Run the command line; Ctrl-C ends it quietly even while it is still being loaded."""
    try:
        import os

        from facetlog.one_thread import ONE_THREAD

        for name in ONE_THREAD:
            os.environ.setdefault(name, "1")
        from facetlog.plain_text import open_streams

        open_streams()
        from facetlog.cli import main

        code = main(sys.argv[1:])
    except KeyboardInterrupt:
        code = INTERRUPTED
    import atexit
    import signal

    # Before all else that is done at the end: another Ctrl-C would end that in the middle, with a
    # traceback.
    atexit.register(signal.signal, signal.SIGINT, signal.SIG_IGN)
    sys.exit(code)


if __name__ == "__main__":
    run()
