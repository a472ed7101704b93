"""The command line: results on stdout, everything else on stderr.

Exit codes: 0 yes or done, 1 a clean no, 2 bad input or usage, 3 engine failure, 130 Ctrl-C.
"""

from collections.abc import Sequence
from typing import Annotated

import typer

from facetlog import __version__
from facetlog.__main__ import INTERRUPTED
from facetlog.commands.classify import classify_command
from facetlog.commands.collect import collect_command
from facetlog.commands.doctor import doctor_command
from facetlog.commands.explain import why_command, why_not_command
from facetlog.commands.map import map_command
from facetlog.commands.mat import mat_app
from facetlog.commands.model.check import check_command
from facetlog.commands.model.compile import compile_command
from facetlog.commands.model.draw import draw_command, sample_command
from facetlog.commands.model.examples import examples_command
from facetlog.commands.model.format import format_command
from facetlog.commands.model.language import (
    list_command,
    lsp_command,
    new_command,
    show_model_command,
    words_command,
)
from facetlog.commands.mount import mount_command
from facetlog.commands.query import query_command
from facetlog.commands.recognize import demo_command, recognize_command, reconstruct_command
from facetlog.commands.record import record_command
from facetlog.commands.scene import convert_command, show_command, validate_command
from facetlog.commands.shared import YES
from facetlog.commands.simulate import simulate_command
from facetlog.errors import InputError
from facetlog.terminal import error, set_loudness

__all__ = ["app", "main"]

app = typer.Typer(
    name="facetlog",
    help="Recognize objects made of flat faces in pictures with known camera poses.",
    no_args_is_help=True,
    add_completion=True,
    context_settings={"help_option_names": ["-h", "--help"]},
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)


def _print_version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"facetlog {__version__}")
        raise typer.Exit


@app.callback()
def _set_up(
    version: Annotated[  # noqa: ARG001 - its callback ends the program
        bool,
        typer.Option(
            "--version", callback=_print_version, is_eager=True, help="Print the version."
        ),
    ] = False,
    quiet: Annotated[
        bool, typer.Option("-q", "--quiet", help="Suppress notes, progress and times.")
    ] = False,
    verbose: Annotated[
        int,
        typer.Option(
            "-v", "--verbose", count=True, help="Log each step with its time; -vv logs more."
        ),
    ] = 0,
) -> None:
    """Set what goes to stderr, for all commands."""
    try:
        set_loudness(quiet=quiet, verbose=verbose)
    except InputError as exc:
        error(str(exc))
        raise typer.Exit(exc.exit_code) from exc


def _make_group(name: str, text: str) -> typer.Typer:
    return typer.Typer(name=name, help=text, no_args_is_help=True, rich_markup_mode=None)


app.command("recognize")(recognize_command)
app.command("reconstruct")(reconstruct_command)
app.command("demo")(demo_command)
app.command("classify")(classify_command)
app.command("collect")(collect_command)
app.command("record")(record_command)
app.command("map")(map_command)
app.command("mount")(mount_command)
app.command("query")(query_command)
app.command("doctor")(doctor_command)
app.command("why")(why_command)
app.command("why-not")(why_not_command)
app.command("simulate")(simulate_command)
app.add_typer(mat_app)

_model = _make_group("model", "List, explain, check, test and draw models in the model language.")
_model.command("new")(new_command)
_model.command("list")(list_command)
_model.command("show")(show_model_command)
_model.command("words")(words_command)
_model.command("check")(check_command)
_model.command("format")(format_command)
_model.command("test")(examples_command)
_model.command("draw")(draw_command)
_model.command("sample")(sample_command)
_model.command("compile")(compile_command)
_model.command("lsp")(lsp_command)
app.add_typer(_model)

_scene = _make_group("scene", "Show, convert and check scenes, meshes and point clouds.")
_scene.command("show")(show_command)
_scene.command("convert")(convert_command)
_scene.command("validate")(validate_command)
app.add_typer(_scene)


def main(argv: Sequence[str]) -> int:
    """Run the command line `argv` (without the program's name) and return its exit code."""
    try:
        app(args=list(argv), prog_name="facetlog")
    except SystemExit as exc:
        return exc.code if isinstance(exc.code, int) else int(exc.code is not None)
    except KeyboardInterrupt:
        return INTERRUPTED
    return YES
