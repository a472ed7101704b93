"""`facetlog mat check`: whether pictures of a thing on a mat suffice, and what to add."""

import json
from pathlib import Path
from typing import Annotated

import typer

from facetlog.commands.shared import NO, YES, AsJson, command
from facetlog.errors import InputError

__all__ = ["check_command"]

SCHEMA = "facetlog-mat-check/1"

Photos = Annotated[Path, typer.Argument(metavar="PHOTOS", help="Folder of the pictures.")]


@command
def check_command(photos: Photos, as_json: AsJson = False) -> int:
    """Says whether pictures of a thing on a mat suffice, and what to add.

    Exit code 0: they suffice, 1: some are missing.
    """
    from facetlog.perception.reading.left_out import lines_of
    from facetlog.perception.reading.mat.advice import advice
    from facetlog.perception.reading.mat.mat_poses import mat_pictures
    from facetlog.terminal import printable, warn

    if not photos.is_dir():
        raise InputError(f"{photos} is no folder: give one of pictures of a mat")
    found = mat_pictures(photos)
    wanted = (*found.faults, *advice(found.pictures))
    problems = lines_of(found.left_out)
    if as_json:
        usable = len(found.pictures)
        about = {"mat": found.mat.paper, "usable": usable, "left_out": list(problems)}
        typer.echo(json.dumps({"schema": SCHEMA, **about, "advice": list(wanted)}))
        return NO if wanted else YES
    for line in problems:
        warn(line)
    count = len(found.pictures) + len(found.left_out)
    typer.echo(f"{found.mat.name}: {len(found.pictures)} of {count} pictures can be used")
    typer.echo(printable("\n".join(wanted or ["they suffice: facetlog recognize takes them"])))
    return NO if wanted else YES
