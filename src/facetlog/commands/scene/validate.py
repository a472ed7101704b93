"""`facetlog scene validate`: whether files are sound scenes, and what is wrong where."""

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from facetlog.commands.shared import NO, YES, AsJson, command
from facetlog.counted import many
from facetlog.errors import InputError
from facetlog.terminal import error, one_line, short_line

if TYPE_CHECKING:
    from facetlog.perception.surfaces.scene_file import SceneFault

__all__ = ["validate_command"]

FORMAT = "facetlog-validate/1"

MOST_LINES = 20
"""Faults of a file that are written as text; what is wrong once is often wrong everywhere."""


@command
def validate_command(
    files: Annotated[
        list[Path],
        typer.Argument(metavar="FILE...", help="Scenes as JSON.", show_default=False),
    ],
    as_json: AsJson = False,
) -> int:
    """Checks scenes against facetlog-scene/1, and their geometry against itself.

    Exit code 0: all are sound, 1: some are not, 2: a file cannot be read.
    """
    code, sound = YES, 0
    for path in files:
        try:
            faults = _faults(path)
        except InputError as exc:  # the other files are checked all the same
            error(str(exc))
            code = exc.exit_code
            continue
        sound += not faults
        code = max(code, NO if faults else YES)
        if as_json:
            typer.echo(json.dumps(_report(path, faults)))
        for fault in () if as_json else faults[:MOST_LINES]:
            typer.echo(short_line(f"{path}: {fault}"))
        if not as_json and len(faults) > MOST_LINES:
            more = many(len(faults) - MOST_LINES, "more fault")
            typer.echo(one_line(f"{path}: {more}: --json has them all"))
    if not as_json:
        typer.echo(f"{many(len(files), 'file')}, {'all' if sound == len(files) else sound} sound")
    return code


def _faults(path: Path) -> "tuple[SceneFault, ...]":
    """The faults for which a scene file is refused, by whatever reads it; none if it is sound."""
    from facetlog.perception.surfaces.scene_file import SceneFileError, read_scene
    from facetlog.query_shell.scene_files import is_raw_shape

    if is_raw_shape(path):
        raise InputError(
            f"{path}: is a mesh or a cloud, no scene: make one of it by facetlog scene convert"
        )
    try:
        read_scene(path)
    except SceneFileError as exc:
        return exc.faults
    return ()


def _report(path: Path, faults: "tuple[SceneFault, ...]") -> dict[str, object]:
    return {
        "schema": FORMAT,
        "file": str(path),
        "sound": not faults,
        "faults": [{"path": fault.path, "message": fault.message} for fault in faults],
    }
