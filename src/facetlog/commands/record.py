"""`facetlog record`: record a finished collection for other programs."""

from pathlib import Path
from typing import Annotated

import typer

from facetlog.commands.robot_options import Mcap
from facetlog.commands.shared import YES, ModelOptions, Overwrite, command
from facetlog.errors import InputError

__all__ = ["record_command"]


@command
def record_command(
    folder: Annotated[
        Path, typer.Argument(metavar="DIR", help="Folder that facetlog collect has written.")
    ],
    models: ModelOptions,
    mcap: Mcap = None,
    overwrite: Overwrite = False,
) -> int:
    """Record a collection for other programs: pictures, odometry, faces and verdicts."""
    from facetlog.recordings.recording_request import check_recording, record_collection

    if mcap is None:
        raise InputError("nothing is to be written: give --mcap FILE")
    check_recording(mcap, folder, models.paths, overwrite=overwrite)
    with models.open_base() as base:
        views = record_collection(folder, mcap, base)
    typer.echo(f"{views} views recorded")
    return YES
