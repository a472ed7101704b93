"""When, where and in which session of the traffic log each run of a collection began and ended."""

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

from facetlog.errors import DeviceError, InputError
from facetlog.robot.collecting.drive import STANDS_SPEED, STANDS_TURNING
from facetlog.robot.collecting.record import read_log, read_record
from facetlog.robot.collecting.request import TRAFFIC_FILE
from facetlog.robot.pioneer.replay import iter_replayed_states, replay
from facetlog.robot.pioneer.state import RobotState
from facetlog.robot.pose2 import Pose2
from facetlog.safe_read import read_regular_text


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


def list_runs(lines: Sequence[Mapping[str, object]], folder: Path) -> tuple[Run, ...]:
    """Return the runs of which a collection's collect.jsonl tells; InputError where it does not say
    where one began.
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
    """Yield the session of each run: the last one that was opened before the run began, and at
    which time (seconds since 1970) the session's clock was at 0.

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


@dataclass(frozen=True, slots=True)
class LastPlace:
    """The last pose in the world that is known of a robot, and `how` it is known, in words."""

    pose: Pose2
    how: str


def last_place(folder: Path) -> LastPlace | None:
    """Return the last place of the last run of a collection; None if nothing is known of it.

    A run that was killed has no end in its log: then the last report of the robot counts, which
    the log of the traffic holds. InputError for a folder or a log that cannot be read.
    """
    lines = read_log(folder)
    last = lines[-1]
    ended = last.get("result") == "ended"
    match last.get("robot") if ended else None:
        case [float(x), float(y), float(heading)]:
            return LastPlace(Pose2(x, y, math.radians(heading)), "where it ended it was")
    heard = _find_last_report(folder, lines)
    if heard is not None:
        return heard
    _, taken = read_record(folder)
    if not taken:
        return None
    place = max(taken, key=lambda view: view.time).robot
    return LastPlace(place, "at its last view it was")


def _find_last_report(folder: Path, lines: Sequence[Mapping[str, object]]) -> LastPlace | None:
    """Return the last report of the last run; None without a log of its traffic."""
    path = folder / TRAFFIC_FILE
    if not path.is_file():
        return None
    sessions = run_sessions(path, list_runs(lines, folder)[-1:])
    found: tuple[Run, RobotState] | None = None
    with suppress(DeviceError):  # a session that ends before its first report
        for session, run, _ in sessions:
            for state in iter_replayed_states(replay(path, session)):
                found = run, state
    if found is None:
        return None
    run, state = found
    stands = abs(state.speed) < STANDS_SPEED and abs(state.turning) < STANDS_TURNING
    how = "when it was last heard it stood at"
    if not stands:
        how = f"when it was last heard it went at {abs(state.speed):.2f} m/s, at"
    return LastPlace(run.place(state.pose), how)
