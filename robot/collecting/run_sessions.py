"""When and where each run of a collection began, and its session in the log of the traffic."""

import json
import math
from collections.abc import Iterator, Mapping
from datetime import datetime
from pathlib import Path

from facetlog.errors import InputError
from facetlog.regular_file import read_regular_text
from facetlog.robot.pose2 import Pose2

__all__ = ["RunStart", "run_sessions", "run_start"]

RunStart = tuple[float, Pose2]
"""When a run began (seconds since 1970), and where the robot then stood in the world."""


def run_start(run: Mapping[str, object], folder: Path) -> RunStart:
    """The start of a run, by its first line in collect.jsonl; InputError if that does not say."""
    match run:
        case {"start": [float() | int() as x, float() | int() as y, float() | int() as heading]}:
            began = run.get("began")
            at = float(began) if isinstance(began, int | float) else 0.0
            return at, Pose2(float(x), float(y), math.radians(heading))
    raise InputError(f"{folder}: collect.jsonl does not say where a run began")


def run_sessions(path: Path, starts: tuple[RunStart, ...]) -> Iterator[tuple[int, Pose2, float]]:
    """The session of each run: the last one that was opened before the run began, where the robot
    stood, and at which time (seconds since 1970) the session's clock was at 0.

    InputError for a log of traffic that cannot be read.
    """
    try:
        lines = read_regular_text(path).splitlines()
    except (OSError, UnicodeDecodeError) as exc:
        raise InputError(f"{path}: cannot be read ({exc})") from exc
    opened = []
    for number, line in enumerate(lines, 1):
        if '"start"' not in line:
            continue
        try:
            about = json.loads(line)
            began = datetime.fromisoformat(str(about["start"])).timestamp()
            opened.append((began, began - float(about["at"])))
        except (ValueError, KeyError, TypeError) as exc:
            raise InputError(f"{path}:{number}: is no line of a traffic log") from exc
    for began, start in starts:
        before = [k for k, (at, _) in enumerate(opened) if at <= began]
        if before:
            yield before[-1], start, opened[before[-1]][1]
