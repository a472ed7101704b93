"""`facetlog mat`: a mat to print, and whether pictures of a thing on it suffice."""

import json
from pathlib import Path
from typing import Annotated

import typer

from facetlog.commands.shared import NO, YES, AsJson, Overwrite, command
from facetlog.errors import InputError
from facetlog.output_file import check_output_file

__all__ = ["mat_app"]

CHECK_SCHEMA = "facetlog-mat-check/1"

mat_app = typer.Typer(name="mat", rich_markup_mode=None, invoke_without_command=True)


@mat_app.callback()
def mat_command(
    context: typer.Context,
    out: Annotated[
        Path | None, typer.Option("-o", "--out", metavar="FILE", help="PDF file to write.")
    ] = None,
    paper: Annotated[
        str, typer.Option("--paper", metavar="SIZE", help="Paper size: A4, A3 or Letter.")
    ] = "A4",
    overwrite: Overwrite = False,
) -> None:
    """Write a PDF of a mat to print: pictures of a thing on it need no other camera poses."""
    if context.invoked_subcommand is None:
        _print_command(out=out, paper=paper, overwrite=overwrite)


@command
def _print_command(out: Path | None, paper: str, *, overwrite: bool) -> int:
    from facetlog.mat_sheet import write_mat
    from facetlog.perception.reading.mat.mats import BAR_MM, MATS, find_mat
    from facetlog.terminal import note

    mat = find_mat(paper)
    if mat is None:
        known = ", ".join(each.paper for each in MATS)
        raise InputError(f"there is no mat for paper {paper!r}: use one of {known}")
    if out is None:
        raise InputError("a mat is written into a file: give one, as -o mat.pdf")
    check_output_file(out, "-o", overwrite=overwrite)
    write_mat(mat, out)
    note(
        f"print {out} on {mat.paper} at 100 % (actual size): its bar is then {BAR_MM:g} mm long; "
        "glue it on board or glass, for a bent mat gives wrong sizes"
    )
    return YES


@mat_app.command("check")
@command
def check_command(
    photos: Annotated[Path, typer.Argument(metavar="PHOTOS", help="Folder of the pictures.")],
    as_json: AsJson = False,
) -> int:
    """Tell whether the pictures of a thing on a mat suffice, and what to add.

    Exit code 0: they suffice, 1: some are missing.
    """
    from facetlog.perception.reading.mat.advice import advice
    from facetlog.perception.reading.mat.mat_poses import find_mat_pictures
    from facetlog.perception.reading.skipped_images import lines_of
    from facetlog.terminal import printable, warn

    if not photos.is_dir():
        raise InputError(f"{photos} is no folder: give one of pictures of a mat")
    found = find_mat_pictures(photos)
    usable, wanted = len(found.pictures), (*found.faults, *advice(found.pictures))
    problems = lines_of(found.left_out)
    if as_json:
        about = {"mat": found.mat.paper, "usable": usable, "left_out": list(problems)}
        typer.echo(json.dumps({"schema": CHECK_SCHEMA, **about, "advice": list(wanted)}))
        return NO if wanted else YES
    for line in problems:
        warn(line)
    count = usable + len(found.left_out)
    typer.echo(f"{found.mat.name}: {usable} of {count} pictures can be used")
    typer.echo(printable("\n".join(wanted or ["they suffice: facetlog recognize takes them"])))
    return NO if wanted else YES
