"""Messages of the command line about errors of a robot and collections that ended early."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from facetlog.errors import DeviceError
from facetlog.robot.collecting.option_words import COLLECT_AGAIN, describe_resume, worded

if TYPE_CHECKING:
    from facetlog.robot.collecting.session import Ended

__all__ = ["COLLECT_AGAIN", "MOUNT_AGAIN", "format_early_end", "reword_errors"]

MOUNT_AGAIN = "call facetlog mount again"


@contextmanager
def reword_errors(again: str) -> Iterator[None]:
    """Translate device errors of the body into the command line's words."""
    try:
        yield
    except DeviceError as exc:
        raise worded(exc, again) from exc


def format_early_end(ended: "Ended", there: int, total: int, *, most: str = "") -> str:
    """Say in one line why a collection ended early, how to go on, and what is there.

    `most` goes before the total.
    """
    again = describe_resume(ended.robot)
    where = (
        "where it stands by odometry"
        if ended.stands
        else "where it was last heard, and may have gone on"
    )
    if ended.robot is None:
        where = "where the robot stands"
    views = f"{there} of {most}{total} views are there"
    why = ended.why if ended.fault is None else str(ended.fault)
    on = "" if again in why else f"; {again}"
    return f"{why}{on} ({where}); {views}"
