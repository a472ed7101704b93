"""Views of a collection one by one, with the scene and verdicts after each."""

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

import numpy as np

from facetlog.errors import InputError
from facetlog.perception.types import Camera, FloatArray
from facetlog.robot.camera.optics import Optics
from facetlog.robot.collecting.next_stop import CHOSEN
from facetlog.robot.collecting.record import (
    TRANSFORMS_FILE,
    WAY_FILE,
    Taken,
    read_log,
    read_record,
    read_robot_tum,
)
from facetlog.robot.collecting.run_sessions import Run, list_runs
from facetlog.robot.pose2 import Pose2
from facetlog.robot.recording import HALF_PIXEL
from facetlog.safe_read import read_regular_text

if TYPE_CHECKING:
    from facetlog.kb.explaining.verdict import Recognition
    from facetlog.perception.scene import Scene

# Of the ball that stands for the best of some candidates, and for one that promised nothing, m.
LARGEST, SMALLEST = 0.05, 0.008
COEFFICIENTS = ("k1", "k2", "p1", "p2", "k3", "k4")


@dataclass(frozen=True, eq=False, slots=True)
class CandidateView:
    """A view from a `place` (3,) that could be taken: the probability `mass` of verdicts that it
    may turn, `seconds` until it is there. `radius` is that of the ball that stands for it (m): its
    area is as what it promised a second.
    """

    place: FloatArray
    mass: float
    seconds: float
    is_chosen: bool
    radius: float

    @property
    def words(self) -> str:
        """For example 'may turn 0.31 verdicts, in 9 s'."""
        return f"may turn {self.mass:.2f} verdicts, in {self.seconds:.0f} s"


def read_candidate_views(
    lines: Sequence[Mapping[str, object]], name: str
) -> tuple[CandidateView, ...]:
    """Return the views among which one was chosen; none for a tour or the first view."""
    rows: object = next(
        (
            line.get("candidates")
            for line in reversed(lines)
            if line.get("result") == CHOSEN and line.get("image") == name
        ),
        None,
    )
    if not isinstance(rows, list) or not rows:
        return ()
    table = np.array(rows, dtype=np.float64).reshape(-1, 6)
    rates = table[:, 3] / np.maximum(table[:, 4], 1e-9)
    most = float(rates.max())
    return tuple(
        CandidateView(
            row[:3],
            float(row[3]),
            float(row[4]),
            bool(row[5]),
            max(LARGEST * math.sqrt(rate / most) if most > 0 else 0.0, SMALLEST),
        )
        for row, rate in zip(table, rates, strict=True)
    )


@dataclass(frozen=True, eq=False, slots=True)
class Moment:
    """A view and what is new with it.

    `picture` is its file as it is. `run` is that of the collection, and `way` the robot's poses in
    the world with their times (seconds since 1970) since the view before. `scene` is what is known
    after the view, None if that is too little; `recognition` what the models say, None where nobody
    asked. `candidates` are the views among which it was chosen, where one was.
    """

    taken: Taken
    picture: bytes
    optics: Optics
    run: Run
    way: tuple[tuple[float, Pose2], ...]
    scene: "Scene | None" = None
    recognition: "Recognition | None" = None
    candidates: tuple[CandidateView, ...] = ()


class Recorder(Protocol):
    """Writes a recording. InputError where it cannot be written."""

    def add(self, moment: Moment) -> None:
        """Record the next view."""

    def close(self) -> None:
        """End the recording; it is whole then."""


def read_moment(
    folder: Path,
    name: str,
    since: float,
    scene: "Scene | None" = None,
    recognition: "Recognition | None" = None,
) -> Moment | None:
    """Return the moment of the view of a name, None if the folder has none; its way begins after
    `since`.

    InputError if the folder is no collection's or cannot be read.
    """
    _, views = read_record(folder)
    log = read_log(folder)
    taken = next((view for view in views if view.name == name), None)
    if taken is None:
        return None
    runs = list_runs(log, folder)
    run = next((run for run in reversed(runs) if run.began <= taken.time), runs[0])
    path = folder / WAY_FILE
    way = read_robot_tum(path) if path.is_file() else []
    try:
        picture = (folder / name).read_bytes()
    except OSError as exc:
        raise InputError(f"{folder / name}: cannot be read ({exc.strerror})") from exc
    return Moment(
        taken,
        picture,
        read_recorded_optics(folder),
        run,
        tuple((at, place) for at, place in way if since < at <= taken.time),
        scene,
        recognition,
        read_candidate_views(log, name),
    )


def read_recorded_optics(folder: Path) -> Optics:
    """Return the camera of a collection's transforms.json; InputError if it holds none."""
    path = folder / TRANSFORMS_FILE
    try:
        content: Mapping[str, object] = json.loads(read_regular_text(path))
        numbers = {key: float(str(value)) for key, value in content.items() if _number(value)}
        camera = Camera(
            int(numbers["w"]),
            int(numbers["h"]),
            numbers["fl_x"],
            numbers["fl_y"],
            numbers["cx"] - HALF_PIXEL,
            numbers["cy"] - HALF_PIXEL,
        )
        coefficients = tuple((key, numbers[key]) for key in COEFFICIENTS if key in numbers)
        model = str(content["camera_model"]) if coefficients else "PINHOLE"
    except (OSError, ValueError, KeyError, AttributeError) as exc:
        raise InputError(f"{path}: holds no camera of a collection ({exc!r})") from exc
    return Optics(camera, model, coefficients)


def _number(value: object) -> bool:
    return isinstance(value, int | float) and math.isfinite(value)
