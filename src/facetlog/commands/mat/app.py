"""`facetlog mat`: the mat to print, and its sub-command."""

from pathlib import Path
from typing import Annotated

import typer

from facetlog.commands.mat.check import check_command
from facetlog.commands.shared import YES, command
from facetlog.errors import InputError
from facetlog.output_file import Overwrite, check_output_file

__all__ = ["mat_app"]

mat_app = typer.Typer(name="mat", rich_markup_mode=None, invoke_without_command=True)


@mat_app.callback()
def mat_command(
    context: typer.Context,
    out: Annotated[
        Path | None, typer.Option("-o", "--out", metavar="FILE", help="The PDF to write.")
    ] = None,
    paper: Annotated[str, typer.Option("--paper", metavar="SIZE", help="A4, A3 or Letter.")] = "A4",
    overwrite: Overwrite = False,
) -> None:
    """Writes a mat to print: of a thing that stands on it, pictures alone are enough."""
    if context.invoked_subcommand is None:
        _written(out, paper, overwrite=overwrite)


@command
def _written(out: Path | None, paper: str, *, overwrite: bool) -> int:
    from facetlog.mat_sheet import write_mat
    from facetlog.perception.reading.mat.mats import BAR_MM, MATS, mat_named
    from facetlog.terminal import note

    mat = mat_named(paper)
    if mat is None:
        there = ", ".join(each.paper for each in MATS)
        raise InputError(f"there is no mat for paper {paper!r}: use one of {there}")
    if out is None:
        raise InputError("a mat is written into a file: give one, as -o mat.pdf")
    check_output_file(out, "-o", overwrite=overwrite)
    write_mat(mat, out)
    note(
        f"print {out} on {mat.paper} at 100 % (actual size): its bar is then {BAR_MM:g} mm long; "
        "glue it on board or glass, for a bent mat gives wrong sizes"
    )
    return YES


mat_app.command("check")(check_command)
