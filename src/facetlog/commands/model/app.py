"""The sub-commands of `facetlog model`."""

import typer

from facetlog.commands.model.builtin import list_command, show_command
from facetlog.commands.model.check import check_command
from facetlog.commands.model.compile import compile_command
from facetlog.commands.model.draw import draw_command
from facetlog.commands.model.examples import examples_command
from facetlog.commands.model.format import format_command
from facetlog.commands.model.lsp import lsp_command
from facetlog.commands.model.new import new_command
from facetlog.commands.model.sample import sample_command
from facetlog.commands.model.words import words_command

__all__ = ["model_app"]

model_app = typer.Typer(
    name="model",
    help="Lists, explains, checks, tests and draws models in the model language.",
    no_args_is_help=True,
    rich_markup_mode=None,
)

model_app.command("new")(new_command)
model_app.command("list")(list_command)
model_app.command("show")(show_command)
model_app.command("words")(words_command)
model_app.command("check")(check_command)
model_app.command("format")(format_command)
model_app.command("test")(examples_command)
model_app.command("draw")(draw_command)
model_app.command("sample")(sample_command)
model_app.command("compile")(compile_command)
model_app.command("lsp")(lsp_command)
