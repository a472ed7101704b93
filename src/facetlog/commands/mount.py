"""`facetlog mount`: where the camera head sits on the robot, by looking at a printed board."""

import json
import math
import time
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from facetlog.commands.robot_options import (
    DEFAULT_SPEED,
    Baud,
    CameraFile,
    CameraUrl,
    Head,
    HeadPort,
    HeadUnheard,
    Latency,
    Model,
    Noiseless,
    RobotAddress,
    Speed,
    checked_head,
    checked_speed,
    ended_by_signals,
    optics_of,
)
from facetlog.commands.robot_words import MOUNT_AGAIN, wording_errors
from facetlog.commands.shared import NO, YES, AsJson, command
from facetlog.errors import DeviceError, InputError
from facetlog.output_file import Overwrite, check_output_file
from facetlog.terminal import note

if TYPE_CHECKING:
    from facetlog.robot.camera.optics import Optics
    from facetlog.robot.mount.board import Board
    from facetlog.robot.mount.fit import MountFit, Sighting
    from facetlog.robot.mount.mount import Mount

__all__ = ["mount_command"]

SCHEMA = "facetlog-mount/1"


@command
def mount_command(
    robot: RobotAddress,
    board: Annotated[
        str, typer.Option("--board", metavar="COLUMNSxROWS", help="Squares of the printed board.")
    ],
    square: Annotated[float, typer.Option("--square", metavar="METRES", help="Side of a square.")],
    out: Annotated[Path, typer.Option("-o", "--out", metavar="TOML", help="The mount's file.")],
    marker: Annotated[
        float,
        typer.Option("--marker", metavar="METRES", help="Side of a ChArUco board's markers."),
    ],
    board_height: Annotated[
        float | None,
        typer.Option(
            "--board-height",
            metavar="METRES",
            help="Of the board's upper left corner over the floor: determines the mast's height.",
        ),
    ] = None,
    prior: Annotated[
        Path | None,
        typer.Option("--mount", metavar="TOML", help="The mount by tape; else the paper's mast."),
    ] = None,
    camera: CameraUrl = None,
    head: Head = "sony-evi-d30",
    head_port: HeadPort = "aux1",
    head_unheard: HeadUnheard = False,
    camera_file: CameraFile = None,
    speed: Speed = DEFAULT_SPEED,
    latency: Latency = None,
    noiseless: Noiseless = False,
    model: Model = None,
    baud: Baud = None,
    overwrite: Overwrite = False,
    as_json: AsJson = False,
) -> int:
    """Calibrates where the camera head sits. Exit code 0: all is determined, 1: not all.

    The robot stands 1 to 2 m before the board, facing it, with half a metre free to both sides.
    """
    from facetlog.perception.atomic_write import write_whole
    from facetlog.robot.mount.fit import fit_mount
    from facetlog.robot.mount.mount import DEFAULT_MOUNT, mount_text, read_mount

    printed = _board(board, square, marker)
    checked_speed(speed)
    checked_head(head, head_port, unheard=head_unheard)
    read = [path for path in (prior, camera_file) if path is not None]
    check_output_file(out, "-o", read, overwrite=overwrite)
    told_optics, _ = optics_of(camera_file, None)
    mount = DEFAULT_MOUNT if prior is None else read_mount(prior)
    sightings, optics = _sightings(
        _Line(
            robot, head, head_port, head_unheard, camera, latency, not noiseless, model, baud, speed
        ),
        printed,
        told_optics,
        mount,
    )
    fit = fit_mount(sightings, optics.camera, mount, board_height=board_height)
    remarks = (
        f"by {fit.sightings} pictures of a board; corners fit to {fit.rms_px:.2f} pixels (rms)",
        *(f"not determined by the motions, value from before: {name}" for name in fit.undetermined),
    )
    write_whole(out, mount_text(fit.mount, remarks=remarks).encode())
    typer.echo(_document(fit) if as_json else _text(fit))
    return NO if fit.undetermined else YES


@dataclass(frozen=True, slots=True)
class _Line:
    """How robot, head and camera are reached."""

    robot: str
    head: str
    head_port: str
    head_unheard: bool
    camera: str | None
    latency: float | None
    noisy: bool
    model: str | None
    baud: int | None
    speed: float


def _board(given: str, square: float, marker: float) -> "Board":
    from facetlog.robot.mount.board import Board

    columns, _, rows = given.lower().partition("x")
    if not (columns.isdecimal() and rows.isdecimal()):
        raise InputError(f"--board {given!r:.40}: give COLUMNSxROWS of squares, as 7x5")
    if not square > 0:
        raise InputError(f"--square {square:g}: give metres, above 0")
    return Board(int(columns), int(rows), square, marker)


def _sightings(
    line: _Line, board: "Board", optics: "Optics | None", mount: "Mount"
) -> "tuple[list[Sighting], Optics]":
    """The board from all sides, and the optics it was seen with."""
    from facetlog.robot.camera.source import open_camera
    from facetlog.robot.collecting.drive import MobileBase
    from facetlog.robot.collecting.mount_session import BoardRig, take_sightings
    from facetlog.robot.collecting.run import open_robot_head
    from facetlog.robot.collecting.simulated_robot import camera_and_optics, with_line
    from facetlog.robot.collecting.steering import Pace
    from facetlog.robot.pioneer.limits import Limits
    from facetlog.robot.pioneer.pioneer import Pioneer
    from facetlog.robot.pose2 import Pose2

    with (
        ended_by_signals(),
        wording_errors(MOUNT_AGAIN),
        ExitStack() as stack,
    ):
        robot = stack.enter_context(
            Pioneer.connect(
                line.robot, model=line.model, limits=Limits(speed=line.speed), baud=line.baud
            )
        )
        seen = camera_and_optics(robot, line.robot, line.camera, optics, note)
        robot.switch_sonars(False)  # nothing here looks at them
        head = open_robot_head(stack, robot, line.head, line.head_port, unheard=line.head_unheard)
        camera = open_camera(seen.camera, latency=line.latency, noisy=line.noisy)
        stack.callback(camera.close)
        robot.enable_motors()
        base = MobileBase(robot, Pose2(), pace=Pace(robot.limits.speed, robot.limits.turning))
        radius = robot.parameters.radius
        rig = BoardRig(base, head, camera, seen.optics, mount, board, radius)
        try:
            return list(take_sightings(rig, note)), seen.optics
        except DeviceError as exc:
            raise with_line(exc, robot.problems, time.monotonic()) from exc


def _rows(fit: "MountFit") -> dict[str, dict[str, object]]:
    """Each number with its deviation, in metres or degrees, and whether it was determined."""
    from facetlog.robot.mount.mount import ANGLES, PARAMETERS

    rows: dict[str, dict[str, object]] = {}
    for name, value, sd in zip(PARAMETERS, fit.mount.values, fit.mount.sds, strict=True):
        angle = name in ANGLES
        rows[f"{name}_deg" if angle else name] = {
            "value": math.degrees(value) if angle else value,
            "sd": math.degrees(sd) if angle else sd,
            "determined": name not in fit.undetermined,
        }
    return rows


def _document(fit: "MountFit") -> str:
    head = {"schema": SCHEMA, "pictures": fit.sightings, "rms_px": fit.rms_px}
    return json.dumps({**head, "mount": _rows(fit)}, indent=1)


def _text(fit: "MountFit") -> str:
    lines = [f"{fit.sightings} pictures, corners fit to {fit.rms_px:.2f} pixels (rms)"]
    for name, row in _rows(fit).items():
        unit = "°" if name.endswith("_deg") else " m"
        remark = "" if row["determined"] else "  not determined: value from before"
        lines.append(
            f"{name.removesuffix('_deg'):<14}{row['value']:+9.4f} ± {row['sd']:.4f}{unit}{remark}"
        )
    return "\n".join(lines)
