"""Where an earlier run left its robot, as the folder of the collection says it."""

import math
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from facetlog.errors import DeviceError
from facetlog.robot.collecting.drive import STANDS_SPEED, STANDS_TURNING
from facetlog.robot.collecting.record import read_log, read_record
from facetlog.robot.collecting.request import TRAFFIC_FILE
from facetlog.robot.collecting.run_sessions import Run, run_sessions, runs_of
from facetlog.robot.pioneer.replay import replay, replayed_states
from facetlog.robot.pioneer.state import RobotState
from facetlog.robot.pose2 import Pose2

__all__ = ["LastPlace", "last_place"]


@dataclass(frozen=True, slots=True)
class LastPlace:
    """The last pose in the world that is known of a robot, and `how` it is known, in words."""

    pose: Pose2
    how: str


def last_place(folder: Path) -> LastPlace | None:
    """The last place of the last run of a collection; None if nothing is known of it.

    A run that was killed has no end in its log: then the last report of the robot counts, which
    the log of the traffic holds. InputError for a folder or a log that cannot be read.
    """
    lines = read_log(folder)
    last = lines[-1]
    ended = last.get("result") == "ended"
    match last.get("robot") if ended else None:
        case [float(x), float(y), float(heading)]:
            return LastPlace(Pose2(x, y, math.radians(heading)), "where it ended it was")
    heard = _last_heard(folder, lines)
    if heard is not None:
        return heard
    _, taken = read_record(folder)
    if not taken:
        return None
    place = max(taken, key=lambda view: view.time).robot
    return LastPlace(place, "at its last view it was")


def _last_heard(folder: Path, lines: Sequence[Mapping[str, object]]) -> LastPlace | None:
    """By the last report of the last run; None without a log of its traffic."""
    path = folder / TRAFFIC_FILE
    if not path.is_file():
        return None
    sessions = run_sessions(path, runs_of(lines, folder)[-1:])
    found: tuple[Run, RobotState] | None = None
    with suppress(DeviceError):  # a session that ends before its first report
        for session, run, _ in sessions:
            for state in replayed_states(replay(path, session)):
                found = run, state
    if found is None:
        return None
    run, state = found
    stands = abs(state.speed) < STANDS_SPEED and abs(state.turning) < STANDS_TURNING
    how = "when it was last heard it stood at"
    if not stands:
        how = f"when it was last heard it went at {abs(state.speed):.2f} m/s, at"
    return LastPlace(run.place(state.pose), how)
