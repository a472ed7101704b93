"""The command line: results on stdout, everything else on stderr.

Exit codes: 0 yes or done, 1 a clean no, 2 bad input or usage, 3 engine failure, 130 Ctrl-C.
"""

from collections.abc import Sequence
from importlib import import_module
from typing import Annotated

import typer

from facetlog import __version__
from facetlog.__main__ import INTERRUPTED
from facetlog.commands.shared import YES
from facetlog.errors import InputError
from facetlog.terminal import error, set_loudness

__all__ = ["main", "make_app"]

COMMANDS = {
    "recognize": "recognize:recognize_command",
    "reconstruct": "recognize:reconstruct_command",
    "demo": "recognize:demo_command",
    "classify": "classify:classify_command",
    "collect": "collect:collect_command",
    "record": "record:record_command",
    "map": "map:map_command",
    "mount": "mount:mount_command",
    "query": "query:query_command",
    "doctor": "doctor:doctor_command",
    "why": "explain:why_command",
    "why-not": "explain:why_not_command",
    "simulate": "simulate:simulate_command",
    "mat": "mat:mat_app",
    "model new": "model.language:new_command",
    "model list": "model.language:list_command",
    "model show": "model.language:show_model_command",
    "model words": "model.language:words_command",
    "model check": "model.check:check_command",
    "model format": "model.format:format_command",
    "model test": "model.examples:examples_command",
    "model draw": "model.draw:draw_command",
    "model sample": "model.draw:sample_command",
    "model compile": "model.compile:compile_command",
    "model lsp": "model.language:lsp_command",
    "scene show": "scene:show_command",
    "scene convert": "scene:convert_command",
    "scene validate": "scene:validate_command",
}
"""Modules of facetlog.commands and functions in them, by the words of the command."""

GROUPS = {
    "model": "List, explain, check, test and draw models in the model language.",
    "scene": "Show, convert and check scenes, meshes and point clouds.",
}


def _print_version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"facetlog {__version__}")
        raise typer.Exit


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


def make_app(wanted: str | None = None) -> typer.Typer:
    """Return the command line, with the command of that name alone if there is one: to load the
    modules of all of them takes longer than most others need.
    """
    app = typer.Typer(
        name="facetlog",
        help="Recognize objects made of flat faces in pictures with known camera poses.",
        no_args_is_help=True,
        add_completion=True,
        context_settings={"help_option_names": ["-h", "--help"]},
        rich_markup_mode=None,
        pretty_exceptions_enable=False,
    )
    app.callback()(_set_up)
    groups = {
        name: typer.Typer(name=name, help=text, no_args_is_help=True, rich_markup_mode=None)
        for name, text in GROUPS.items()
    }
    names = {words.partition(" ")[0] for words in COMMANDS}
    for words, place in COMMANDS.items():
        first, _, last = words.partition(" ")
        if wanted in names and first != wanted:
            continue
        module, _, function = place.partition(":")
        command = getattr(import_module(f"facetlog.commands.{module}"), function)
        if isinstance(command, typer.Typer):
            app.add_typer(command)
        else:
            (groups[first] if last else app).command(last or first)(command)
    for group in groups.values():
        if group.registered_commands:
            app.add_typer(group)
    return app


def main(argv: Sequence[str]) -> int:
    """Run the command line `argv` (without the program's name) and return its exit code."""
    try:
        make_app(argv[0] if argv else None)(args=list(argv), prog_name="facetlog")
    except SystemExit as exc:
        return exc.code if isinstance(exc.code, int) else int(exc.code is not None)
    except KeyboardInterrupt:
        return INTERRUPTED
    return YES
