"""Shared by the commands with a robot: options, the camera, and signals."""

import math
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from signal import SIGHUP, SIGTERM, SIGTSTP
from types import FrameType
from typing import TYPE_CHECKING, Annotated

import typer

from facetlog.errors import InputError

if TYPE_CHECKING:
    from facetlog.robot.camera.optics import Optics
    from facetlog.robot.pose2 import Pose2

__all__ = [
    "Mcap",
    "RobotAddress",
    "RobotOptions",
    "Start",
    "end_at_signals",
    "parse_number_list",
    "parse_start",
]

CAMERA_TOML = "camera.toml"
HEAD_PORTS = ("aux1", "aux2", "aux3")
# The head that obeys though its cable cannot carry its answers.
UNHEARD_HEAD = "canon-vc-c4"
DEFAULT_SPEED, LARGEST_SPEED = 0.2, 0.5
# Besides the signal of Ctrl-C. SIGSTOP and SIGKILL cannot be caught: then the line's owner stops
# the robot.
ENDING = (SIGTERM, SIGHUP, SIGTSTP)

RobotAddress = Annotated[
    str,
    typer.Argument(
        metavar="ROBOT",
        help="Address: tcp:HOST:PORT, HOST:PORT, serial:PATH, or a path as /dev/ttyUSB0.",
    ),
]
Start = Annotated[
    str | None,
    typer.Option(
        "--start", metavar="X,Y,HEADING_DEG", help="Initial pose of the robot in the world (m)."
    ),
]
Mcap = Annotated[
    Path | None,
    typer.Option("--mcap", metavar="FILE", help="Record to a .mcap file, for ROS 2 tools."),
]


@dataclass(frozen=True, slots=True)
class RobotOptions:
    """How robot, camera head and camera are reached."""

    camera: Annotated[
        str | None,
        typer.Option(
            "--camera",
            metavar="URL",
            help="Camera: 0, /dev/video0, rtsp://…, http://… (stream or .jpg) or a file; default "
            "for a simulated robot: http://127.0.0.1:8100/.",
        ),
    ] = None
    head: Annotated[
        str,
        typer.Option("--head", metavar="KIND", help="Camera head: sony-evi-d30 or canon-vc-c4."),
    ] = "sony-evi-d30"
    head_port: Annotated[
        str,
        typer.Option(
            "--head-port",
            metavar="PORT",
            help="Port of the head: aux1, aux2 or aux3 of the robot, or its own address.",
        ),
    ] = "aux1"
    head_unheard: Annotated[
        bool,
        typer.Option(
            "--head-unheard",
            help="The Canon head's cable carries no answers: record its commanded angles.",
        ),
    ] = False
    camera_file: Annotated[
        Path | None,
        typer.Option(
            "--camera-file",
            metavar="TOML",
            help="Calibration of the camera (default: camera.toml beside the tour).",
        ),
    ] = None
    speed: Annotated[
        float, typer.Option("--speed", metavar="M/S", help="Largest speed of the robot.")
    ] = DEFAULT_SPEED
    latency: Annotated[
        float | None,
        typer.Option("--latency", metavar="SECONDS", help="Largest delay of camera pictures."),
    ] = None
    noiseless: Annotated[
        bool,
        typer.Option(
            "--noiseless", help="The camera has no noise: equal pictures do not mean it is frozen."
        ),
    ] = False
    model: Annotated[
        str | None,
        typer.Option(
            "--model", metavar="NAME", help="Model of the robot, if it reports an unknown one."
        ),
    ] = None
    baud: Annotated[
        int | None,
        typer.Option(
            "--baud", metavar="N", help="Baud rate of a serial line (default: found by trying)."
        ),
    ] = None

    def check(self) -> None:
        """Raise InputError for a speed, a head or a port that cannot be."""
        if not 0 < self.speed <= LARGEST_SPEED:
            raise InputError(
                f"--speed {self.speed:g}: give metres a second, above 0 to {LARGEST_SPEED}"
            )
        if self.head_port not in HEAD_PORTS and not any(sign in self.head_port for sign in ":/"):
            raise InputError(
                f"--head-port {self.head_port!r:.40}: give aux1, aux2 or aux3 of the robot, or the "
                "head's own line (serial:PATH, /dev/ttyUSB1, tcp:HOST:PORT)"
            )
        if self.head_unheard and self.head != UNHEARD_HEAD:
            raise InputError(
                f"--head-unheard is for {UNHEARD_HEAD}: a {self.head:.40} answers, leave it out"
            )

    def read_optics(self, tour: Path | None = None) -> tuple["Optics | None", float | None]:
        """Return the camera with its unit in metres: the given one, or camera.toml beside the tour.

        None where there is neither.
        """
        from facetlog.camera_file import read_optics

        file = self.camera_file
        if file is None and tour is not None and (tour.parent / CAMERA_TOML).is_file():
            file = tour.parent / CAMERA_TOML
        return (None, None) if file is None else read_optics(file)


def parse_start(text: str | None) -> "Pose2":
    """Return the robot's pose in the world; by default its origin, facing along x."""
    from facetlog.robot.pose2 import Pose2

    if text is None:
        return Pose2()
    x, y, heading = parse_number_list(text, "--start", "X,Y,HEADING_DEG", 3)
    return Pose2(x, y, math.radians(heading))


def parse_number_list(text: str, option: str, form: str, *counts: int) -> tuple[float, ...]:
    """Return the numbers between commas; InputError unless there are as many as a count says."""
    try:
        values = tuple(float(part) for part in text.split(","))
    except ValueError:
        values = ()
    if len(values) not in counts or not all(map(math.isfinite, values)):
        raise InputError(f"{option} {text!r:.40}: give {form}")
    return values


@contextmanager
def end_at_signals() -> Iterator[None]:
    """End the body at SIGTERM, SIGHUP and SIGTSTP as at Ctrl-C: the robot is stopped first.

    A terminal that is closed, or a connection to this machine that is lost, sends SIGHUP, and
    Ctrl-Z sends SIGTSTP: a program that is put to sleep cannot stop what drives on.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = {number: signal.signal(number, _raise_interrupt) for number in ENDING}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _raise_interrupt(_number: int, _frame: FrameType | None) -> None:
    raise KeyboardInterrupt
