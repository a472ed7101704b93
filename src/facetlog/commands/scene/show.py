"""`facetlog scene show`: what a scene, a mesh or a cloud holds."""

import json
from pathlib import Path
from typing import Annotated

import typer

from facetlog.commands.scene.shape import (
    AUTO,
    NONE,
    OverrideFile,
    Scale,
    Sensor,
    ShapeArgument,
    Unit,
    Up,
    read,
)
from facetlog.commands.shared import YES, AsJson, command
from facetlog.output_file import Overwrite, check_output_file
from facetlog.terminal import one_line, warn

__all__ = ["show_command"]

PICTURE_PX = 960
PICTURE_SUFFIX = ".png"


@command
def show_command(
    shape: ShapeArgument,
    up: Up = AUTO,
    unit: Unit = NONE,
    sensor: Sensor = NONE,
    override_file: OverrideFile = False,
    scale: Scale = None,
    out: Annotated[
        Path | None, typer.Option("-o", "--out", metavar="PNG", help="Draws it into this file.")
    ] = None,
    overwrite: Overwrite = False,
    as_json: AsJson = False,
) -> int:
    """Says what a scene, mesh or cloud holds: objects, largest faces, unit and up."""
    from facetlog.commands.scene.summary import Summary

    if out is not None:
        check_output_file(out, "-o", (shape,), suffixes=(PICTURE_SUFFIX,), overwrite=overwrite)
    found = read(shape, up, unit, sensor, scale, override=override_file)
    if out is not None:
        from facetlog.perception.atomic_write import write_whole
        from facetlog.perception.surfaces.drawing.thumbnail import thumbnail

        write_whole(out, thumbnail(found.scene, PICTURE_PX))
    summary = Summary(found)
    for line in found.scene.warnings:
        warn(line)
    if as_json:
        typer.echo(json.dumps(summary.to_json(), allow_nan=False))
    else:
        typer.echo("\n".join(map(_aligned, summary.lines())))
    return YES


def _aligned(line: str) -> str:
    """The line with its columns, unless a name in it holds what cannot be printed."""
    return line if line.isprintable() else one_line(line)
