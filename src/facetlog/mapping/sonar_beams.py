"""Sonar measurements of a collection, from the log of the robot's traffic."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from facetlog.errors import DeviceError
from facetlog.robot.collecting.request import TRAFFIC_FILE
from facetlog.robot.collecting.run_sessions import Run, run_sessions
from facetlog.robot.pioneer.connecting import Connected
from facetlog.robot.pioneer.replay import iter_replayed_states, replay
from facetlog.robot.pioneer.state import SonarRange
from facetlog.robot.pose2 import Pose2

FARTHEST = 5.0
"""Metres; what a sonar reports where nothing echoes (Pioneer 2 manual)."""
# From 0.1 m on (Pioneer 2 manual), right to 1 cm: what it reports nearer may be at any distance.
NEAREST = 0.12


@dataclass(frozen=True, slots=True)
class Beam:
    """One measurement: from where in the world, which way, how far, whether anything echoed, and
    when: seconds since 1970 of a log, else by the clock of the robot's reports.
    """

    x: float
    y: float
    heading: float
    range: float
    echo: bool
    at: float = 0.0


@dataclass(frozen=True, slots=True)
class Driven:
    """Sonar beams and robot radius from the logs of a collection's runs."""

    beams: tuple[Beam, ...] = ()
    radius: float = 0.0


def driven(folder: Path, runs: Sequence[Run]) -> Driven:
    """Return the beams of a collection in the world, and its robot's radius; nothing without a log.

    A session that came to none of the `runs`, as of a robot that could not be opened, is left out.
    InputError for a log that cannot be read.
    """
    path = folder / TRAFFIC_FILE
    if not path.is_file():
        return Driven()
    beams: list[Beam] = []
    radius = 0.0
    for session, run, since in run_sessions(path, runs):
        opened: list[Connected] = []
        try:
            for beam in _beams(path, session, run, since, opened):
                # One by one: what came before a fault is kept.
                beams += (beam,)
        except DeviceError:
            pass  # a session that ends before its first report
        if opened:
            radius = max(radius, opened[0].parameters.radius)
    return Driven(tuple(beams), radius)


def _beams(
    path: Path, session: int, run: Run, since: float, opened: list[Connected]
) -> Iterator[Beam]:
    """Yield each measurement once, from where the robot was when it was reported."""
    known: dict[int, float] = {}
    for state in iter_replayed_states(replay(path, session), connected=opened.append):
        robot = run.place(state.pose)
        for beam in iter_new_beams(robot, state.sonars, known):
            yield replace(beam, at=since + beam.at)


def iter_new_beams(
    robot: Pose2, sonars: Iterable[SonarRange], known: dict[int, float]
) -> Iterator[Beam]:
    """Yield the beams of what sonars measured since they were last asked, of a robot in the world.

    `known` are the times of what was known of each, by its number; it is brought up to date.
    """
    for sonar in sonars:
        place = sonar.place
        if place is None or known.get(sonar.index) == sonar.at:
            continue
        known[sonar.index] = sonar.at
        if sonar.range < NEAREST:
            continue
        at = robot.compose(Pose2(place.x, place.y, place.heading))
        farthest = sonar.range >= FARTHEST
        reach = min(sonar.range, FARTHEST)
        yield Beam(at.x, at.y, at.heading, reach, not farthest, sonar.at)
