"""The sub-commands of `facetlog scene`."""

import typer

from facetlog.commands.scene.convert import convert_command
from facetlog.commands.scene.show import show_command
from facetlog.commands.scene.validate import validate_command

__all__ = ["scene_app"]

scene_app = typer.Typer(
    name="scene",
    help="Shows, converts and checks scenes, meshes and point clouds.",
    no_args_is_help=True,
    rich_markup_mode=None,
)

scene_app.command("show")(show_command)
scene_app.command("convert")(convert_command)
scene_app.command("validate")(validate_command)
