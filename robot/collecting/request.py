"""The request of a collection, and its views that are there already."""

from dataclasses import dataclass
from pathlib import Path

from facetlog.errors import InputError
from facetlog.robot.camera.optics import Optics
from facetlog.robot.collecting.next_stop import Chooser
from facetlog.robot.collecting.record import LOG_FILE, Taken, read_record
from facetlog.robot.collecting.route import Circle
from facetlog.robot.collecting.tour_file import Tour
from facetlog.robot.mount.mount import Mount
from facetlog.robot.pose2 import Pose2

TRAFFIC_FILE = "traffic.jsonl"


@dataclass(frozen=True, eq=False, slots=True)
class Request:
    """The views to collect, with which devices and how; `start` is the robot's pose now.

    A camera or optics of None are the simulated camera's, if the robot is simulated.
    `keep_out` is a radius about the tour's target, circles, or None for a radius made from the
    tour: no part of the robot enters. `resume` goes on with the folder's collection.
    """

    address: str
    tour: Tour
    folder: Path
    camera: str | None
    optics: Optics | None
    mount: Mount
    start: Pose2
    start_stated: bool = True
    """Whether the user said where the robot stands; else the world's origin is there."""
    head: str = "sony-evi-d30"
    head_port: str = "aux1"
    head_unheard: bool = False
    latency: float | None = None
    noisy: bool = True
    keep_out: float | tuple[Circle, ...] | None = None
    speed: float = 0.2
    resume: bool = False
    model: str | None = None
    baud: int | None = None
    chooser: Chooser | None = None
    """Chooses the views of an exploration; the tour then has a target and no views."""
    until: str | None = None
    """The goal of the exploration, as the user gave it."""


def read_earlier_views(request: Request) -> tuple[Taken, ...]:
    """Read the views taken before; InputError for a folder that holds something else."""
    folder = request.folder
    if request.resume:
        check_begun(folder)
        about, taken = read_record(folder)
        if about.get("tour") != request.tour.name:
            raise InputError(
                f"{folder} was collected for tour {about.get('tour')!r}: give that tour again, or "
                "another folder"
            )
        return taken
    try:
        folder.mkdir(parents=True, exist_ok=True)
        present = sorted(path.name for path in folder.iterdir())
    except OSError as exc:
        raise InputError(f"{folder} cannot be used: {exc.strerror}: give another -o") from exc
    if LOG_FILE in present:
        raise InputError(f"{folder} holds a collection: go on with it by --resume, or give another")
    # A log of traffic alone is what an earlier run left that could not begin.
    others = [name for name in present if name != TRAFFIC_FILE]
    if others:
        raise InputError(f"{folder} holds {others[0]}: give an empty folder with -o")
    return ()


def check_begun(folder: Path) -> None:
    """Raise InputError for a folder without a collection to resume."""
    if not (folder / LOG_FILE).is_file():
        raise InputError(f"{folder} holds no collection to go on with: leave out --resume")


def find_missing_views(tour: Tour, taken: tuple[Taken, ...]) -> list[int]:
    """Return the indices of the tour's views that are not taken yet."""
    there = {view.name for view in taken}
    return [i for i, view in enumerate(tour.views) if view.name not in there]
