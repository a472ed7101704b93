"""Shared by the commands with a robot: options, the camera, and warnings on stderr."""

import math
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
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
    "DEFAULT_SPEED",
    "Baud",
    "CameraFile",
    "CameraUrl",
    "Head",
    "HeadPort",
    "HeadUnheard",
    "Latency",
    "Mcap",
    "Model",
    "Noiseless",
    "RobotAddress",
    "Speed",
    "Start",
    "checked_head",
    "checked_speed",
    "ended_by_signals",
    "numbers_in",
    "optics_of",
    "parsed_start",
]

CAMERA_TOML = "camera.toml"
HEAD_PORTS = ("aux1", "aux2", "aux3")
# The head that obeys though its cable cannot carry its answers.
UNHEARD_HEAD = "canon-vc-c4"
DEFAULT_SPEED, LARGEST_SPEED = 0.2, 0.5
# Besides that of Ctrl-C. SIGSTOP and SIGKILL cannot be caught: the line's owner stops the robot.
ENDING = (SIGTERM, SIGHUP, SIGTSTP)

RobotAddress = Annotated[
    str,
    typer.Argument(
        metavar="ROBOT", help="tcp:HOST:PORT, HOST:PORT, serial:PATH, or a path as /dev/ttyUSB0."
    ),
]
CameraUrl = Annotated[
    str | None,
    typer.Option(
        "--camera",
        metavar="URL",
        help="0, /dev/video0, rtsp://…, http://… (stream or .jpg), file; of a robot that says it "
        "is simulated http://127.0.0.1:8100/, if nothing is said.",
    ),
]
Noiseless = Annotated[
    bool,
    typer.Option("--noiseless", help="Pictures without noise: equal ones are no frozen camera."),
]
Head = Annotated[
    str, typer.Option("--head", metavar="KIND", help="Camera head: sony-evi-d30 or canon-vc-c4.")
]
HeadPort = Annotated[
    str,
    typer.Option("--head-port", metavar="PORT", help="aux1, aux2, aux3, or an address of its own."),
]
HeadUnheard = Annotated[
    bool,
    typer.Option(
        "--head-unheard",
        help="The Canon head's cable carries no answers: record its commanded angles.",
    ),
]
CameraFile = Annotated[
    Path | None,
    typer.Option(
        "--camera-file", metavar="TOML", help="The camera's calibration; else beside the tour."
    ),
]
Start = Annotated[
    str | None,
    typer.Option(
        "--start", metavar="X,Y,HEADING_DEG", help="Where the robot stands in the world, metres."
    ),
]
Speed = Annotated[float, typer.Option("--speed", metavar="M/S", help="Largest speed of the robot.")]
Latency = Annotated[
    float | None,
    typer.Option("--latency", metavar="SECONDS", help="Largest delay of the camera's pictures."),
]
Model = Annotated[
    str | None,
    typer.Option("--model", metavar="NAME", help="The robot's model, where it names an unknown."),
]
Baud = Annotated[
    int | None, typer.Option("--baud", metavar="N", help="Of a serial line; else it is found.")
]


Mcap = Annotated[
    Path | None,
    typer.Option("--mcap", metavar="FILE", help="Record for ROS 2 tools and Rerun: a file .mcap."),
]


def checked_head(kind: str, port: str, *, unheard: bool) -> None:
    """InputError for an unknown head or a port that it cannot have."""
    if port not in HEAD_PORTS and not any(sign in port for sign in ":/"):
        raise InputError(
            f"--head-port {port!r:.40}: give aux1, aux2 or aux3 of the robot, or the head's own "
            "line (serial:PATH, /dev/ttyUSB1, tcp:HOST:PORT)"
        )
    if unheard and kind != UNHEARD_HEAD:
        raise InputError(
            f"--head-unheard is for {UNHEARD_HEAD}: a {kind:.40} answers, leave it out"
        )


def checked_speed(speed: float) -> float:
    """The largest speed in m/s; InputError beyond that of a walk."""
    if not 0 < speed <= LARGEST_SPEED:
        raise InputError(f"--speed {speed:g}: give metres a second, above 0 to {LARGEST_SPEED}")
    return speed


def optics_of(camera_file: Path | None, tour: Path | None) -> tuple["Optics | None", float | None]:
    """The given camera, or that of camera.toml beside the tour, with its unit in metres.

    None where there is neither.
    """
    from facetlog.camera_file import read_optics

    if camera_file is None and tour is not None and (tour.parent / CAMERA_TOML).is_file():
        camera_file = tour.parent / CAMERA_TOML
    return (None, None) if camera_file is None else read_optics(camera_file)


def parsed_start(text: str | None) -> "Pose2":
    """The robot's pose in the world; by default its origin, facing along x."""
    from facetlog.robot.pose2 import Pose2

    if text is None:
        return Pose2()
    x, y, heading = numbers_in(text, "--start", "X,Y,HEADING_DEG", 3)
    return Pose2(x, y, math.radians(heading))


def numbers_in(text: str, option: str, form: str, *counts: int) -> tuple[float, ...]:
    try:
        values = tuple(float(part) for part in text.split(","))
    except ValueError:
        values = ()
    if len(values) not in counts or not all(map(math.isfinite, values)):
        raise InputError(f"{option} {text!r:.40}: give {form}")
    return values


@contextmanager
def ended_by_signals() -> Iterator[None]:
    """SIGTERM, SIGHUP and SIGTSTP end the body as Ctrl-C does: the robot is stopped first.

    A terminal that is closed, or a connection to this machine that is lost, sends SIGHUP, and
    Ctrl-Z sends SIGTSTP: a program that is put to sleep cannot stop what drives on.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = {number: signal.signal(number, _interrupt) for number in ENDING}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _interrupt(_number: int, _frame: FrameType | None) -> None:
    raise KeyboardInterrupt
