"""The driver's messages, worded for the command line.

The driver's errors name the call that helps ("call enable_motors()"). At the command line it cannot
be called: the command is run again, with options.
"""

import re
from collections.abc import Iterator
from contextlib import contextmanager

from facetlog.errors import DeviceError

__all__ = ["COLLECT_AGAIN", "MOUNT_AGAIN", "worded", "wording_errors"]

COLLECT_AGAIN = "go on with --resume --start X,Y,HEADING_DEG"
MOUNT_AGAIN = "call facetlog mount again"
AGAIN = "AGAIN"
# In this order: the driver adds the first to others that say what to do.
WORDS = (
    (re.compile(r"(enable_motors\(\).*); then call clear_stop\(\) to drive on"), r"\1"),
    (re.compile(r"then call clear_stop\(\) to drive on"), f"then {AGAIN}"),
    (re.compile(r"(MOTORS button) or call enable_motors\(\)"), rf"\1, then {AGAIN}"),
    (re.compile(r"then (call enable_motors\(\)|switch the motors on)"), f"then {AGAIN}"),
    (re.compile(r"then (go on with )?--resume(?! --start)"), f"then {AGAIN}"),
    (re.compile(r"\bmodel= "), "--model "),
    (re.compile(r"\bbaud=(?=\d)"), "--baud "),
    (
        re.compile(r"(the CTS line of its port \(pin 2\) is high)"),
        r"\1; a Canon head whose cable carries no answers needs --head-unheard",
    ),
)


def worded(fault: DeviceError, again: str) -> DeviceError:
    """The error in the command line's words; `again` says how to continue the command.

    >>> stop = DeviceError("STOP button pressed: pull it out, then call enable_motors()")
    >>> str(worded(stop, MOUNT_AGAIN))
    'STOP button pressed: pull it out, then call facetlog mount again'
    """
    text = str(fault)
    for pattern, words in WORDS:
        text = pattern.sub(words, text)
    return type(fault)(text.replace(AGAIN, again))


@contextmanager
def wording_errors(again: str) -> Iterator[None]:
    """Device errors of the body leave it in the command line's words."""
    try:
        yield
    except DeviceError as exc:
        raise worded(exc, again) from exc
