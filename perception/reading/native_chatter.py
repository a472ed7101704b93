"""What C libraries write to the terminal meanwhile, kept from it."""

import os
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from io import BytesIO

__all__ = ["native_chatter"]


@contextmanager
def native_chatter() -> Iterator[BytesIO]:
    """Holds what is written to file descriptor 2, once the block has ended; else empty.

    The C libraries inside OpenCV write there with no switch to stop them, so it leads to a
    temporary file meanwhile.
    """
    said = BytesIO()
    if sys.stderr is not None:
        sys.stderr.flush()
    try:
        terminal = os.dup(2)
    except OSError:  # started without a stderr
        yield said
        return
    with tempfile.TemporaryFile() as sink:
        os.dup2(sink.fileno(), 2)
        try:
            yield said
        finally:
            os.dup2(terminal, 2)
            os.close(terminal)
            sink.seek(0)
            said.write(sink.read())
