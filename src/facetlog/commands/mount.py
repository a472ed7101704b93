"""`facetlog mount`: calibrate the camera head's mount by pictures of a printed board."""

import json
import math
import time
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from facetlog.commands.robot_options import RobotAddress, RobotOptions, end_at_signals
from facetlog.commands.robot_words import MOUNT_AGAIN, reword_errors
from facetlog.commands.shared import NO, YES, AsJson, Overwrite, command
from facetlog.errors import DeviceError, InputError
from facetlog.output_file import check_output_file
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
        str,
        typer.Option(
            "--board", metavar="COLUMNSxROWS", help="Number of squares of the printed board."
        ),
    ],
    square: Annotated[
        float, typer.Option("--square", metavar="METRES", help="Side length of a square.")
    ],
    out: Annotated[
        Path, typer.Option("-o", "--out", metavar="TOML", help="File to write the mount to.")
    ],
    marker: Annotated[
        float,
        typer.Option(
            "--marker", metavar="METRES", help="Side length of the markers of a ChArUco board."
        ),
    ],
    reach: RobotOptions,
    board_height: Annotated[
        float | None,
        typer.Option(
            "--board-height",
            metavar="METRES",
            help="Height of the board's upper left corner above the floor, for the mast's height.",
        ),
    ] = None,
    prior: Annotated[
        Path | None,
        typer.Option(
            "--mount", metavar="TOML", help="Initial mount, by tape (default: the paper's mast)."
        ),
    ] = None,
    overwrite: Overwrite = False,
    as_json: AsJson = False,
) -> int:
    """Calibrate the position and orientation of the camera head on the robot.

    Exit code 0: all values are determined, 1: not all. The robot stands 1 to 2 m before the board,
    facing it, with half a metre free to both sides.
    """
    from facetlog.perception.atomic_write import write_atomically
    from facetlog.robot.mount.fit import fit_mount
    from facetlog.robot.mount.mount import DEFAULT_MOUNT, format_mount, read_mount

    printed = _parse_board(board, square, marker)
    reach.check()
    read = [path for path in (prior, reach.camera_file) if path is not None]
    check_output_file(out, "-o", read, overwrite=overwrite)
    mount = DEFAULT_MOUNT if prior is None else read_mount(prior)
    sightings, optics = _take_sightings(robot, reach, printed, mount)
    fit = fit_mount(sightings, optics.camera, mount, board_height=board_height)
    remarks = (
        f"by {fit.sightings} pictures of a board; corners fit to {fit.rms_px:.2f} pixels (rms)",
        *(f"not determined by the motions, value from before: {name}" for name in fit.undetermined),
    )
    write_atomically(out, format_mount(fit.mount, remarks=remarks).encode())
    typer.echo(_format_json(fit) if as_json else _format_text(fit))
    return NO if fit.undetermined else YES


def _parse_board(given: str, square: float, marker: float) -> "Board":
    from facetlog.robot.mount.board import Board

    columns, _, rows = given.lower().partition("x")
    if not (columns.isdecimal() and rows.isdecimal()):
        raise InputError(f"--board {given!r:.40}: give COLUMNSxROWS of squares, as 7x5")
    if not square > 0:
        raise InputError(f"--square {square:g}: give metres, above 0")
    return Board(int(columns), int(rows), square, marker)


def _take_sightings(
    address: str, reach: RobotOptions, board: "Board", mount: "Mount"
) -> "tuple[list[Sighting], Optics]":
    """Take pictures of the board from all sides; return what they show, and the camera's optics."""
    from facetlog.robot.camera.source import open_camera
    from facetlog.robot.collecting.drive import MobileBase
    from facetlog.robot.collecting.mount_session import BoardRig, take_sightings
    from facetlog.robot.collecting.run import open_robot_head
    from facetlog.robot.collecting.simulated_robot import add_line_hint, choose_camera_and_optics
    from facetlog.robot.collecting.steering import Pace
    from facetlog.robot.pioneer.limits import Limits
    from facetlog.robot.pioneer.pioneer import Pioneer
    from facetlog.robot.pose2 import Pose2

    optics, _ = reach.read_optics()
    with end_at_signals(), reword_errors(MOUNT_AGAIN), ExitStack() as stack:
        robot = stack.enter_context(
            Pioneer.connect(
                address, model=reach.model, limits=Limits(speed=reach.speed), baud=reach.baud
            )
        )
        seen = choose_camera_and_optics(robot, address, reach.camera, optics, note)
        robot.switch_sonars(False)  # nothing here looks at them
        head = open_robot_head(
            stack, robot, reach.head, reach.head_port, unheard=reach.head_unheard
        )
        camera = open_camera(seen.camera, latency=reach.latency, noisy=not reach.noiseless)
        stack.callback(camera.close)
        robot.enable_motors()
        base = MobileBase(robot, Pose2(), pace=Pace(robot.limits.speed, robot.limits.turning))
        radius = robot.parameters.radius
        rig = BoardRig(base, head, camera, seen.optics, mount, board, radius)
        try:
            return list(take_sightings(rig, note)), seen.optics
        except DeviceError as exc:
            raise add_line_hint(exc, robot.problems, time.monotonic()) from exc


def _list_values(fit: "MountFit") -> dict[str, dict[str, object]]:
    """Return each value with its deviation, in metres or degrees, and whether it is determined."""
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


def _format_json(fit: "MountFit") -> str:
    head = {"schema": SCHEMA, "pictures": fit.sightings, "rms_px": fit.rms_px}
    return json.dumps({**head, "mount": _list_values(fit)}, indent=1)


def _format_text(fit: "MountFit") -> str:
    lines = [f"{fit.sightings} pictures, corners fit to {fit.rms_px:.2f} pixels (rms)"]
    for name, row in _list_values(fit).items():
        unit = "°" if name.endswith("_deg") else " m"
        remark = "" if row["determined"] else "  not determined: value from before"
        lines.append(
            f"{name.removesuffix('_deg'):<14}{row['value']:+9.4f} ± {row['sd']:.4f}{unit}{remark}"
        )
    return "\n".join(lines)
