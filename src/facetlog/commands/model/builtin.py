"""`facetlog model list` and `show`: the models that come with facetlog."""

import json
from typing import Annotated

import typer

from facetlog.commands.shared import YES, AsJson, command
from facetlog.errors import InputError
from facetlog.terminal import one_line

__all__ = ["list_command", "show_command"]


@command
def list_command(as_json: AsJson = False) -> int:
    """Lists the models that come with facetlog, each with what it describes."""
    from facetlog.grammar.library import BUILTIN, builtin_names, read_text
    from facetlog.grammar.reading.parse import parse
    from facetlog.grammar.source import Source

    rows = []
    for name in sorted(builtin_names()):
        path = BUILTIN / f"{name}.model"
        (model,) = parse(Source(str(path), read_text(path))).file.models
        rows.append({"name": name, "text": model.doc.value if model.doc else "", "path": str(path)})
    if as_json:
        typer.echo(json.dumps(rows, indent=1))
        return YES
    width = max(len(row["name"]) for row in rows)
    for row in rows:
        typer.echo(f"{row['name']:<{width}}  {row['text']}")
    return YES


@command
def show_command(
    name: Annotated[str, typer.Argument(metavar="NAME", help="A model that comes with facetlog.")],
) -> int:
    """Prints the text of a model that comes with facetlog: to read, or to copy and change."""
    from facetlog.grammar.library import BUILTIN, builtin_names, read_text

    if name not in builtin_names():
        raise InputError(f"{one_line(name)}: no such model; facetlog model list lists them")
    typer.echo(read_text(BUILTIN / f"{name}.model"), nl=False)
    return YES
