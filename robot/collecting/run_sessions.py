"""When and where each run of a collection began, and its session in the log of the traffic."""

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

from facetlog.errors import InputError
from facetlog.regular_file import read_regular_text
from facetlog.robot.pose2 import Pose2

__all__ = ["Run", "run_sessions", "runs_of"]


@dataclass(frozen=True, slots=True)
class Run:
    """A run of a collection: when it began (seconds since 1970), and the pose of odometry's origin
    in the world.
    """

    began: float
    origin: Pose2

    def place(self, odometry: Pose2) -> Pose2:
        """Return where the robot was in the world by its odometry."""
        return self.origin.compose(odometry)


def runs_of(lines: Sequence[Mapping[str, object]], folder: Path) -> tuple[Run, ...]:
    """The runs of which a collection's collect.jsonl tells; InputError where it does not say where
    one began.
    """
    return tuple(
        Run(_seconds(line.get("began")), _start(line, folder)) for line in lines if "schema" in line
    )


def _start(line: Mapping[str, object], folder: Path) -> Pose2:
    match line.get("start"):
        case [float() | int() as x, float() | int() as y, float() | int() as heading]:
            return Pose2(float(x), float(y), math.radians(heading))
    raise InputError(f"{folder}: collect.jsonl does not say where a run began")


def _seconds(value: object) -> float:
    return float(value) if isinstance(value, int | float) else 0.0


def run_sessions(path: Path, runs: Sequence[Run]) -> Iterator[tuple[int, Run, float]]:
    """The session of each run: the last one that was opened before the run began, and at which time
    (seconds since 1970) the session's clock was at 0.

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
    for run in runs:
        before = [k for k, (at, _) in enumerate(opened) if at <= run.began]
        if before:
            yield before[-1], run, opened[before[-1]][1]
