"""`facetlog record`: a collection that is there as a recording for other programs."""

from pathlib import Path
from typing import Annotated

import typer

from facetlog.commands.robot_options import Mcap
from facetlog.commands.shared import YES, Models, Trust, command
from facetlog.errors import InputError
from facetlog.output_file import Overwrite

__all__ = ["record_command"]


@command
def record_command(
    folder: Annotated[
        Path, typer.Argument(metavar="DIR", help="What `facetlog collect` has left there.")
    ],
    mcap: Mcap = None,
    overwrite: Overwrite = False,
    models: Models = None,
    trust: Trust = False,
) -> int:
    """Records a collection for other programs: pictures, odometry, faces and verdicts."""
    from facetlog.pipeline import open_models
    from facetlog.recordings.recording_request import check_recording, record_collection

    if mcap is None:
        raise InputError("nothing is to be written: give --mcap FILE")
    check_recording(mcap, folder, models or (), overwrite=overwrite)
    with open_models(tuple(models or ()), trusted=trust) as base:
        views = record_collection(folder, mcap, base)
    typer.echo(f"{views} views recorded")
    return YES
