"""The way that a robot has driven, in a file that is up to date with every view."""

from pathlib import Path

from facetlog.robot.collecting.record import (
    WAY_FILE,
    Taken,
    read_robot_tum,
    robot_tum,
    write_file,
)
from facetlog.robot.collecting.session import Ended, Listener
from facetlog.robot.pose2 import Pose2

__all__ = ["DrivenWay"]


class DrivenWay:
    """Keeps the robot's poses in the world, and passes on what a listener is told after writing.

    `epoch` is when the reports' clock was zero (seconds since 1970). With `resume` the way of the
    folder's earlier runs stays before this one's.
    """

    def __init__(self, folder: Path, epoch: float, listener: Listener, *, resume: bool) -> None:
        self._path, self._epoch, self._listener = folder / WAY_FILE, epoch, listener
        self.stamped: list[tuple[float, Pose2]] = []
        """Times (seconds since 1970) and poses, those of earlier runs first."""
        if resume and self._path.is_file():
            self.stamped = read_robot_tum(self._path)

    def moved(self, at: float, place: Pose2) -> None:
        """Takes the pose of a report."""
        self.stamped.append((self._epoch + at, place))

    def write(self) -> None:
        """Writes the file; InputError where it cannot be written."""
        write_file(self._path, robot_tum(self.stamped).encode())

    def view_taken(self, done: int, total: int, view: Taken) -> None:
        """See `Listener`."""
        self.write()
        self._listener.view_taken(done, total, view)

    def warn(self, message: str) -> None:
        """See `Listener`."""
        self._listener.warn(message)

    def note(self, message: str) -> None:
        """See `Listener`."""
        self._listener.note(message)

    def ended_early(self, ended: Ended, there: int, total: int) -> None:
        """See `Listener`."""
        self._listener.ended_early(ended, there, total)
